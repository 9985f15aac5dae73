"""Branch coverage of the package by room, from what `make coverage` measured.

Compiled functions run as machine code, which no tracer sees: they are left out of the measurement.
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from pathlib import Path


def main(report: Path, least: float) -> int:
    """Print a row a room; 1 where all together are below `least` percent."""
    files = json.loads(report.read_text(encoding="utf-8"))["files"]
    rooms: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for name, content in files.items():
        parts, summary = Path(name).parts, content["summary"]
        room = parts[1] if len(parts) > 2 else "(top)"
        for key in (room, "all"):
            rooms[key][0] += summary["covered_lines"] + summary["covered_branches"]
            rooms[key][1] += summary["num_statements"] + summary["num_branches"]
    shares = {room: 100.0 * hit / max(count, 1) for room, (hit, count) in rooms.items()}
    for room in sorted(shares, key=lambda name: (name == "all", shares[name])):
        print(f"{room:14s} {shares[room]:6.1f} %")
    return int(shares["all"] < least)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), float(sys.argv[2])))
