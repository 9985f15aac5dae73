"""The paper's scenes and plots: what is chosen, what is measured, and how it is shown."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from stplan.bench import paper, paper_table
from stplan.bench.named_scenes import chosen_scenes
from stplan.errors import UsageError

SCENES = Path(__file__).parents[2] / "scenes"
_chosen = partial(chosen_scenes, SCENES, small=paper.SMALL_FIGURES, every=tuple(paper.FIGURES))


def test_every_scene_of_the_paper_is_shipped() -> None:
    assert len(_chosen([], full=True)) == len(paper.FIGURES) > 20
    assert list(_chosen(["tunnel"], full=False)) == ["tunnel/tunnel"]
    with pytest.raises(UsageError, match="no scene 'moon'"):
        _chosen(["moon"], full=True)


def test_both_recipes_plan_a_scene_of_the_paper_at_about_the_same_cost() -> None:
    files = _chosen(["three-agents/symmetric"], full=True)
    (one,) = paper.compare(files, 60.0, progress=lambda line: None)
    assert one.default.figures.certified
    assert one.paper.figures.certified
    assert one.paper.figures.found_by == "dijkstra"
    assert 1.0 <= one.paper.cost / one.default.cost < 1.01
    text = paper_table.files([one], [])["paper.md"].decode()
    assert "plans 1 of 1 scenes" in text


def test_a_plot_shows_every_way_and_how_it_grows() -> None:
    timings = [
        paper.IterationTimes("paper-knots", size, dict(zip(paper.WAYS, seconds, strict=True)))
        for size, *seconds in ((30, 30e-3, 900e-6, np.nan), (60, 60e-3, 3600e-6, np.nan))
    ]
    powers = paper.growths(timings, "paper-knots")
    assert powers["default"] == pytest.approx(1.0)
    assert powers["paper"] == pytest.approx(2.0)
    assert np.isnan(powers["all pairs"])
    files = paper_table.files([], timings)
    assert files["paper-knots.png"].startswith(b"\x89PNG")
    assert "| exponent" in files["paper.md"].decode()


def test_without_a_broad_phase_contacts_grow_with_the_square_of_the_knots() -> None:
    """Counted: entries of the Hessian, which hold a block for every pair that may be felt."""
    (plot,) = (one for one in paper.PLOTS if one.name == "paper-knots")
    counted = {}
    for way in ("default", "all pairs"):
        counts = []
        for size in (30, 60):
            scene = paper.WAYS[way](plot.scene(size, 0))
            figures, _ = paper.run(paper.with_solver(scene, outer_iterations=1, max_iterations=1))
            counts.append(figures.hessian_nonzeros)
        counted[way] = counts[1] / counts[0]
    assert counted["all pairs"] > 3.5
    assert counted["default"] < 2.5
