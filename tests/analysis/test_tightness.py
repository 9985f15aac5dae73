"""The tightest spots: the same from the arrays as in the certificate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stplan.analysis import tightness
from stplan.analysis.tightness import certified_spots, pair_spots, tightest, wall_spots
from stplan.certify.certificate import certify
from tests.analysis.crowds import ANN, EVE, SAM, crowd_of, scene_of

KIM = "id: kim, start: [-5, 1.01], goal: [5, 1.01], after_arrival: vanish"


def test_arrays_and_certificate_say_the_same():
    scene = scene_of(SAM, ANN, EVE, KIM, top="map: {rectangle: [-9, -9, 9, 9.7]}\n")
    low = [[-5, 9, 0], [0, 8, 8], [5, 9, 20]]
    crowd = crowd_of(scene, kim=[[-5, 1.01, 0], [5, 1.01, 10]], eve=low)
    certificate = certify(scene, crowd.free_space, crowd.lines)
    pairs, walls = certified_spots(crowd, certificate)
    for certified, found in ((pairs, pair_spots(crowd)), (walls, wall_spots(crowd))):
        assert len(found) > 2
        gaps = [spot.clearance for spot in found]
        assert gaps == sorted(gaps)
        known = {spot.who: spot for spot in certified}
        assert {spot.who for spot in found} == known.keys()
        for spot in found:
            assert spot.clearance == pytest.approx(known[spot.who].clearance, abs=1e-9)
            assert spot.time == pytest.approx(known[spot.who].time, abs=1e-9)
            assert spot.place == pytest.approx(known[spot.who].place, abs=1e-9)
            assert spot.needed == known[spot.who].needed


def test_what_is_tight():
    scene = scene_of(SAM, ANN, EVE, KIM)
    spots = pair_spots(crowd_of(scene, kim=[[-5, 1.01, 0], [5, 1.01, 10]]))
    (spot,) = tightest(spots)
    assert spot.who == ("sam", "kim")
    assert spot.clearance == pytest.approx(0.01)
    assert spot.share == pytest.approx(0.01)
    assert (spot.needed, spot.time) == (1.0, 0.0)
    assert spot.place == pytest.approx((-5.0, 0.505))


def test_without_walls_or_pairs_nothing_is_tight():
    crowd = crowd_of(scene_of(SAM, ANN))
    assert wall_spots(crowd) == []
    nobody = replace(crowd, collides=np.zeros((2, 2), dtype=bool))
    assert pair_spots(nobody) == []


def test_of_many_pairs_those_that_come_near_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    low = [[-5, 9, 0], [0, 8, 8], [5, 9, 20]]
    crowd = crowd_of(scene_of(SAM, ANN, EVE, KIM), kim=[[-5, 1.01, 0], [5, 1.01, 10]], eve=low)
    every = pair_spots(crowd)
    reach = tightness.REACH * float(np.median(crowd.radii))
    monkeypatch.setattr(tightness, "MOST_PAIRS", 0)
    near = pair_spots(crowd)
    assert set(near) <= set(every)
    assert {spot for spot in every if spot.clearance < reach} <= set(near)
    assert len(near) > 0
