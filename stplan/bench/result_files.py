"""The files of a measurement: NAME.csv, NAME.md and, where there is something to see, NAME.png."""

from __future__ import annotations


def result_files(
    name: str, csv: str, markdown: str, picture: bytes | None = None
) -> dict[str, bytes]:
    """Their contents by name."""
    texts = {f"{name}.csv": csv.encode(), f"{name}.md": markdown.encode()}
    return texts if picture is None else texts | {f"{name}.png": picture}
