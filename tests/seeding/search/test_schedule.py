"""The schedule of search: what one round has ruled out, the next does not try again."""

from __future__ import annotations

from stplan.problem.planning_problem import PlanningProblem
from stplan.seeding.search.levels import Levels
from stplan.seeding.search.schedule import MOST_EFFORT, SOON_EFFORT, Search, schedule
from stplan.seeding.seeder import Budget
from stplan.world import build_free_space
from tests.seeding.tight_families import make_scene, rectangle


def lane() -> Levels:
    """A swap in a lane without a pocket."""
    journeys = [((1.0, 0.4), (5.0, 0.4)), ((5.0, 0.4), (1.0, 0.4))]
    scene = make_scene("lane", rectangle(0, 0, 6, 0.8), [], journeys, horizon=20.0)
    return Levels(PlanningProblem.from_scene(scene, build_free_space(scene)))


def test_efforts_rise_and_every_margin_gets_all_of_them() -> None:
    stages = schedule(3)
    efforts = [stage.effort for stage in stages]
    assert efforts == sorted(efforts)
    assert (efforts[0], efforts[-1]) == (SOON_EFFORT, MOST_EFFORT)
    assert all({stage.level for stage in stages if stage.effort == e} == {0, 1, 2} for e in efforts)


def test_what_is_ruled_out_is_not_searched_again() -> None:
    levels = lane()
    soon = Search(levels, (SOON_EFFORT, SOON_EFFORT)).attempt(Budget())
    assert not soon.clear
    assert soon.tries > 0
    lines: list[str] = []
    later = Search(levels, (SOON_EFFORT + 1, MOST_EFFORT)).attempt(Budget(progress=lines.append))
    assert not later.clear
    assert (later.tries, lines) == (0, [])
    assert [reason.kind for reason in later.reasons] == ["blocked"]


def test_levels_are_made_once() -> None:
    levels = lane()
    assert levels.at(1.02) is levels.at(1.02)
    assert levels.at(1.02) is not levels.at(1.05)
