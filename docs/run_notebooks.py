"""Run the notebooks and keep what they print and draw: `make notebooks`."""

from __future__ import annotations

from pathlib import Path

import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).parent / "notebooks"
LIMIT = 300


def run(path: Path) -> nbformat.NotebookNode:
    """A notebook as it is after all of it has run; an error in a cell is one here."""
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=LIMIT, record_timing=False).execute(cwd=FOLDER)
    return notebook


def main() -> None:
    """Run all, in place."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        notebook = run(path)
        for number, cell in enumerate(notebook.cells):
            cell.metadata.clear()
            cell.id = f"{path.stem}-{number}"
        # What tells the machine, not the notebook.
        notebook.metadata.language_info = {"name": "python"}
        nbformat.write(notebook, path)
        print(path)


if __name__ == "__main__":
    main()
