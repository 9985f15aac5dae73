"""Robots that do one task after another: all are done, and little time is lost to others."""

from __future__ import annotations

from tests.claims.plans import planned


def test_robots_in_single_lane_aisles_do_all_their_tasks(claim):
    """Six robots in single-lane aisles do all their tasks, each planned some way ahead"""
    found = planned("tasks/order-picking").report.throughput
    assert found is not None
    claim("order-picking", "tasks done of 36", found.tasks, at_least=36)
    claim("order-picking", "time that tasks take alone over what they take, of all robots",
          found.busy, at_least=0.8, at_most=1.0)  # fmt: skip
    claim("order-picking", "tasks an hour over the bound", found.share, at_least=0.6, at_most=1.0)
