"""What is said of costs."""

from __future__ import annotations

import numpy as np

from stplan.analysis.cost_bound import CostBound
from stplan.analysis.joint_bounds import Together
from stplan.explain.costs import cost_section, payments


def bound(costs, least) -> CostBound:
    names = tuple(f"a{k}" for k in range(len(costs)))
    return CostBound(names, np.array(costs), np.array(least))


def test_those_who_pay_most_of_the_difference_are_named_first():
    found = bound([3.0, 10.0, 1.0, 2.0], [1.0, 2.0, 1.0, 1.9])
    section = cost_section(found)
    assert section.lead == (
        "All agents together pay 16 J s, and at least 5.9 on any plan, so this one is at most 171 % "
        "above the best; who pays the difference:"
    )
    assert [fact.sentence for fact in section.facts] == [
        "a1 pays 10, 8 more than alone (79% of the difference)",
        "a0 pays 3, 2 more than alone (20% of the difference)",
    ]
    assert [one.agent for one in payments(found)] == ["a1", "a0"]


def test_gates_that_all_have_to_queue_at_are_named():
    group = Together("gate", np.array([0, 2]), 1.25, (0.5, -2.0), 0.8)
    found = CostBound(("ann", "bob", "cid"), np.array([3.0, 1.0, 3.0]), np.ones(3), (group,))
    section = cost_section(found)
    assert section.lead.startswith("All agents together pay 7 J s, and at least 4.25 on any plan")
    assert section.facts[0].sentence == (
        "ann and cid pass 0.8 m at (0.5, -2) one after another, "
        "for which they pay at least 1.25 more on any plan"
    )
    assert section.facts[0].as_dict()["agents"] == ("ann", "cid")
    assert len(section.facts) == 3
    crossing = Together("crossing", np.array([0, 2]), 1.25, (0.5, -2.0))
    found = CostBound(("ann", "bob", "cid"), np.array([3.0, 1.0, 3.0]), np.ones(3), (crossing,))
    assert cost_section(found).facts[0].sentence == (
        "ann and cid cross each other's ways around (0.5, -2), "
        "for which they pay at least 1.25 more on any plan"
    )


def test_who_has_to_meet_is_named():
    meeting = Together("meeting", np.array([0, 1]), 1.25, (0.5, -2.0))
    found = CostBound(("ann", "bob"), np.array([3.0, 3.0]), np.ones(2), (meeting,))
    assert cost_section(found).facts[0].sentence == (
        "ann and bob have to meet, for which they pay at least 1.25 more on any plan"
    )


def test_a_crowd_that_shares_alike_is_not_all_named():
    assert len(payments(bound([2.0] * 50, [1.0] * 50))) == 10


def test_nothing_to_gain_and_nothing_to_pay():
    assert cost_section(bound([1.0005], [1.0])).lead.endswith("there is nothing to gain.")
    assert cost_section(bound([0.0], [0.0])).lead == "Nobody has to pay anything."
