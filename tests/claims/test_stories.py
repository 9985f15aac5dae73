"""Pond, flash mob and safari: what the weights and times of a scene can tell agents to do."""

from __future__ import annotations

import numpy as np
import pytest

from tests.claims.plans import (
    arrival,
    curves,
    deviation,
    mean_distance,
    nearest,
    path_length,
    planned,
    sharpest_turn,
    straight_length,
    strongest_acceleration,
)


@pytest.mark.claims
def test_the_message_is_delivered_in_a_hurry(claim):
    """An agent meets another "to deliver a message" and then arrives "faster than the other agents"."""
    leads = {}
    for story in ("messenger", "strangers"):
        found = curves(f"pond/{story}")
        others = min(arrival(own) for agent, own in found.items() if agent != "mia")
        leads[story] = others - arrival(found["mia"])
    claim("pond-messenger", "messenger's lead at arrival, s", leads["messenger"], at_least=2.0)
    claim(
        "pond-strangers", "her lead with no message to deliver, s", leads["strangers"], at_most=1.0
    )
    ways = [path_length(curves(f"pond/{story}")["mia"]) for story in ("messenger", "strangers")]
    claim("pond-messenger", "her way over that with no message", ways[0] / ways[1], at_least=1.1)


@pytest.mark.claims
def test_two_meet_and_everyone_arrives_together(claim):
    """An agent meets a second one, "yet arrives at his end goal at the same time"."""
    found = curves("pond/meeting")
    claim("pond-meeting", "first to last arrival, s", np.ptp([arrival(own) for own in found.values()]),
          at_most=0.5)  # fmt: skip


def test_strangers_keep_to_themselves(claim):
    """A third story shows agents "ignorant of each other"."""
    found = curves("pond/strangers")
    longest = max(path_length(own) / straight_length(own) for own in found.values())
    claim("pond-strangers", "longest path over straight", longest, at_most=1.05)


@pytest.mark.parametrize(
    "story",
    [
        *(pytest.param(name, marks=pytest.mark.claims) for name in ("messenger", "meeting")),
        "strangers",
        "friends",
    ],
)
def test_nobody_turns_on_the_spot(story, claim):
    """Trajectories are "smooth": agents round their corners, also where they meet somebody."""
    found = curves(f"pond/{story}").values()
    claim(f"pond-{story}", "sharpest turn while moving, degrees", max(map(sharpest_turn, found)),
          at_most=30.0)  # fmt: skip
    claim(f"pond-{story}", "strongest acceleration, m/s2", max(map(strongest_acceleration, found)),
          at_most=3.0)  # fmt: skip


def test_friends_walk_together_for_as_long_as_it_is_worth_it(claim):
    """A grouping term lets friends "tend to stick together" where a meeting would only touch."""
    friends, strangers = (curves(f"pond/{story}") for story in ("friends", "strangers"))
    until = max(arrival(own) for found in (friends, strangers) for own in found.values())
    near, far = (mean_distance(found["mia"], found["ben"], until) for found in (friends, strangers))
    claim("pond-friends", "mean distance over that of strangers", near / far, at_most=0.9)
    least = nearest(friends["mia"], friends["ben"])
    claim("pond-friends", "nearest that the two come, m", least, at_most=8.0)


@pytest.mark.claims
def test_the_flash_mob_smiles_in_the_wanted_order(claim):
    """A flash mob's order is controlled "through the preferred end time parameter"."""
    found = curves("flash-mob/flash-mob")
    agents = planned("flash-mob/flash-mob").scene.agents
    times = np.array([arrival(found[agent.id]) for agent in agents])
    wanted = np.array([agent.preferred_time for agent in agents])
    claim("flash-mob", "pairs that arrive in the wrong order",
          float((np.subtract.outer(times, times)[np.triu_indices(len(times), 1)] > 0).sum()),
          at_most=0)  # fmt: skip
    claim("flash-mob", "most that someone is off its time, s", np.abs(times - wanted).max(),
          at_most=1.0)  # fmt: skip
    ends = np.array([found[agent.id][-1, :2] for agent in agents])
    assert (ends == [agent.goal for agent in agents]).all()


@pytest.mark.claims
def test_sam_outruns_the_baboons(claim):
    """Sam "arrives safely at the truck, escaping the baboons and avoiding the elephant"."""
    found = curves("safari/safari")
    baboons = [own for agent, own in found.items() if agent.startswith("baboon")]
    assert len(baboons) == 10
    claim("safari", "Sam's lead over the first baboon, s",
          min(map(arrival, baboons)) - arrival(found["sam"]), at_least=1.0)  # fmt: skip
    claim("safari", "nearest that a baboon comes to Sam on his way, m",
          min(nearest(found["sam"], own) for own in baboons), at_least=1.5)  # fmt: skip
    claim("safari", "nearest that Sam comes to the elephant, m",
          nearest(found["sam"], found["elephant"]), at_least=3.5)  # fmt: skip


@pytest.mark.claims
def test_the_elephant_is_untroubled(claim):
    """The massive elephant "is untroubled, and will stubbornly continue on its path"."""
    found = curves("safari/safari")
    claim("safari", "elephant's deviation, m", deviation(found["elephant"]), at_most=0.5)
    claim("safari", "Sam's detour over the elephant's", deviation(found["sam"])
          / max(deviation(found["elephant"]), 1e-3), at_least=20)  # fmt: skip
