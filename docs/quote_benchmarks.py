"""Put what `stplan bench` wrote into these pages: `python docs/quote_benchmarks.py outputs/bench`.

Tables stand between a line `<!-- bench NAME -->` and the next `<!-- end -->`; pictures go beside the others.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
_BLOCK = re.compile(r"(<!-- bench (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def quoted(page: str, folder: Path) -> str:
    """`page` with the tables of `folder` in its blocks; blocks without a table stay as they are."""

    def fill(block: re.Match[str]) -> str:
        table = folder / f"{block[2]}.md"
        if not table.exists():
            return block[0]
        return f"{block[1]}\n{table.read_text(encoding='utf-8').strip()}\n\n{block[3]}"

    return _BLOCK.sub(fill, page)


def main(folder: Path) -> None:
    """Renew the tables and pictures of the pages that quote benchmarks."""
    for page in (HERE / "performance.md", HERE / "seeding.md", HERE / "method.md"):
        page.write_text(quoted(page.read_text(encoding="utf-8"), folder), encoding="utf-8")
    for picture in sorted(folder.glob("*.png")):
        shutil.copyfile(picture, HERE / "pictures" / f"bench-{picture.name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
