"""The script that puts measured tables into the page on performance."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "performance.md").read_text(encoding="utf-8")


def quoting():
    spec = importlib.util.spec_from_file_location("quoting", DOCS / "quote_benchmarks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_only_blocks_with_a_table_are_renewed(tmp_path):
    (tmp_path / "agents.md").write_text("| new |\n")
    page = (
        "a\n<!-- bench agents -->\nold\n<!-- end -->\nb\n<!-- bench walls -->\nkept\n<!-- end -->\n"
    )
    once = quoting().quoted(page, tmp_path)
    assert once == page.replace("old\n", "\n| new |\n\n")
    assert quoting().quoted(once, tmp_path) == once


def test_the_page_has_a_table_of_every_benchmark_and_its_pictures():
    blocks = re.findall(r"<!-- bench (\w+) -->\n(.*?)<!-- end -->", PAGE, re.DOTALL)
    assert [name for name, _ in blocks] == [
        "machine", "figures", "agents", "knots", "walls", "rival", "convergence", "paper",
        "repulsion", "quality", "draws", "metric", "crowds", "batch", "scale", "replanning", "movingai",
        "startup",
    ]  # fmt: skip
    assert all(text.strip() for _, text in blocks)
    for picture in re.findall(r"\]\((pictures/[^)]+)\)", PAGE):
        assert (DOCS / picture).is_file(), picture
