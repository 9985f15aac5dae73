"""Three agents in six variants: mass, size and friendship decide who gives way."""

from __future__ import annotations

from tests.claims.plans import arrival, curves, deviation, mean_distance, nearest

SCENE = "three-agents"
AGENTS = ("sam", "ann", "ben")


def _deviation(variant: str, agent: str) -> float:
    return deviation(curves(f"{SCENE}/{variant}")[agent])


def _most(variant: str) -> float:
    return max(_deviation(variant, agent) for agent in ("ann", "ben"))


def test_without_interaction_agents_collide(claim):
    """In "the naive case" without interactions, agents go straight and collide."""
    found = curves(f"{SCENE}/none")
    worst = max(deviation(curve) for curve in found.values())
    claim("three-agents-none", "largest deviation from straight, m", worst, at_most=0.01)
    least = nearest(found["sam"], found["ann"])
    claim("three-agents-none", "least distance over needed 1.5 m", least / 1.5, at_most=0.9)


def test_equal_agents_share_the_detour(claim):
    """The "standard symmetric collision" makes equals give way alike."""
    sam, ann = (_deviation("symmetric", agent) for agent in ("sam", "ann"))
    claim("three-agents-symmetric", "smaller over larger detour", min(sam, ann) / max(sam, ann),
          at_least=0.3)  # fmt: skip


def test_a_stubborn_snake_keeps_its_line(claim):
    """A "stubborn snake" of the same size "forces the scared humans to move out of its path"."""
    heavy = _deviation("mass", "sam")
    claim("three-agents-mass", "snake's over humans' deviation", heavy / _most("mass"),
          at_most=0.05)  # fmt: skip
    claim("three-agents-mass", "snake's over an equal's deviation",
          heavy / _deviation("symmetric", "sam"), at_most=0.1)  # fmt: skip


def test_a_large_light_elk_yields(claim):
    """A "large elk who is still scared" changes its way "just as the human agents change theirs"."""
    elk = _deviation("size", "sam")
    claim("three-agents-size", "elk's over humans' deviation", elk / _most("size"), at_least=0.25)
    claim("three-agents-size", "elk's over elephant's deviation",
          elk / _deviation("size-and-mass", "sam"), at_least=10)  # fmt: skip


def test_an_elephant_goes_straight(claim):
    """A "large and stubborn elephant" goes straight while humans "significantly alter" theirs."""
    claim("three-agents-size-and-mass", "elephant's deviation, m",
          _deviation("size-and-mass", "sam"), at_most=0.1)  # fmt: skip
    claim("three-agents-size-and-mass", "humans' detour over that around the snake",
          _most("size-and-mass") / _most("mass"), at_least=1.5)  # fmt: skip


def test_friends_stick_together(claim):
    """Two friends "stick closer to each other on their way"."""
    pairs = [
        [curves(f"{SCENE}/{variant}")[agent] for agent in ("ann", "ben")]
        for variant in ("friends", "symmetric")
    ]
    until = max(arrival(own) for pair in pairs for own in pair)
    together, apart = (mean_distance(*pair, until) for pair in pairs)
    claim("three-agents-friends", f"mean distance all the way over {apart:.2f} m without grouping",
          together / apart, at_most=0.9)  # fmt: skip
