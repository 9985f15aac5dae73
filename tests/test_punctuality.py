"""Scenes that leave hardly enough time for their limits of motion: found all the same, within all limits."""

from __future__ import annotations

import numpy as np
import pytest

from stplan.callbacks import never, unheard
from stplan.compiled import working_time
from stplan.errors import StoppedError
from stplan.hastening import arrivals_of
from stplan.planner import find_initial_curves, prepare
from stplan.punctuality import punctual_seeds
from stplan.scene import Scene, parse_scene

# Three with long errands through two doors, to and fro, in the time that the longest of them takes.
ERRANDS = """\
stplan: 1
horizon: 26
minimise: arrivals
map:
  rectangle: [0, 0, 13.5, 8.75]
  obstacles:
    - {rectangle: [6.5, 0, 6.7, 3]}
    - {rectangle: [6.5, 4.4, 6.7, 8.75]}
    - {rectangle: [8.5, 0, 8.7, 2.6]}
    - {rectangle: [8.5, 4.1, 8.7, 8.75]}
defaults: {after_arrival: vanish}
agents:
  - {id: a, radius: 0.3, start: [11.8, 4.0], waypoints: [[7.9, 8.0]],
     goal: [2.2, 5.3], max_speed: 1.12}
  - {id: b, radius: 0.4, start: [12.3, 8.0], waypoints: [[0.6, 6.5], [5.7, 1.7]],
     goal: [1.7, 4.6], max_speed: 1.17, after_arrival: stay}
  - {id: c, radius: 0.25, start: [7.5, 7.1], waypoints: [[13.1, 2.5], [0.6, 8.1]],
     goal: [12.6, 0.9], max_speed: %s}
"""


def errands(speed: float = 1.56) -> Scene:
    return parse_scene(ERRANDS % speed)


def test_long_errands_in_hardly_enough_time_are_found_within_all_limits() -> None:
    (initial,) = find_initial_curves(prepare(errands()))
    assert initial.certificate.holds
    assert (arrivals_of(initial.world_lines) <= 26.0).all()
    for agent, curve in zip(errands().agents, initial.world_lines.curves(), strict=True):
        steps = np.diff(curve, axis=0)
        assert agent.max_speed is not None
        assert (np.hypot(*steps[:, :2].T) <= agent.max_speed * steps[:, 2] * (1 + 1e-9)).all()


def test_nothing_is_looked_for_after_the_deadline_or_where_somebody_may_go_at_any_speed() -> None:
    problem = prepare(errands())
    late = punctual_seeds(problem, working_time(), progress=unheard, stop=never)
    assert list(late) == []
    text = (ERRANDS % 1.56).replace(", max_speed: 1.12}", "}").replace("minimise: arrivals\n", "")
    free = parse_scene(text)
    seeds = punctual_seeds(prepare(free), working_time() + 60.0, progress=unheard, stop=never)
    assert list(seeds) == []


def test_whoever_is_stopped_meanwhile_has_nothing() -> None:
    said: list[str] = []

    def stop() -> bool:
        return any(line.startswith("looking for curves in") for line in said)

    with pytest.raises(StoppedError):
        find_initial_curves(prepare(errands()), progress=said.append, stop=stop)
