"""stplan: collision-free space-time trajectories for many unequal agents in tight spaces.

    import stplan

    scene = stplan.load_scene("scene.yaml")
    plan = stplan.plan(scene)

Names are loaded when first used, so that ``import stplan`` costs nothing. What is in ``__all__`` is public:
it changes only with a note in the changelog, and what is to go is deprecated, with a `DeprecationWarning`
that names what takes its place, for one minor version at least.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stplan import errors
    from stplan.api.building import AgentSpec, build_scene, scene_text
    from stplan.api.pictures import plot
    from stplan.api.results import diff, sample, to_pandas, to_xarray
    from stplan.certify.certificate import Certificate
    from stplan.costs.floor_cost import FloorCost
    from stplan.costs.registry import added_costs
    from stplan.improvement.budget import ImprovementBudget
    from stplan.nlp.derivatives import check_derivatives
    from stplan.planner import Plan, improve, seed, write_plan
    from stplan.problem.world_lines import WorldLines
    from stplan.replanning.execution import check, plan, replan
    from stplan.scene import load_scene, parse_scene
    from stplan.scene.model import Agent, Scene

    __version__: str

__all__ = [
    "Agent",
    "AgentSpec",
    "Certificate",
    "FloorCost",
    "ImprovementBudget",
    "Plan",
    "Scene",
    "WorldLines",
    "__version__",
    "added_costs",
    "build_scene",
    "check",
    "check_derivatives",
    "diff",
    "errors",
    "improve",
    "load_scene",
    "parse_scene",
    "plan",
    "plot",
    "replan",
    "sample",
    "scene_text",
    "seed",
    "to_pandas",
    "to_xarray",
    "write_plan",
]

_HOMES = {
    "Agent": "stplan.scene.model",
    "AgentSpec": "stplan.api.building",
    "Certificate": "stplan.certify.certificate",
    "FloorCost": "stplan.costs.floor_cost",
    "ImprovementBudget": "stplan.improvement.budget",
    "Plan": "stplan.planner",
    "Scene": "stplan.scene.model",
    "WorldLines": "stplan.problem.world_lines",
    "added_costs": "stplan.costs.registry",
    "build_scene": "stplan.api.building",
    "check": "stplan.replanning.execution",
    "check_derivatives": "stplan.nlp.derivatives",
    "diff": "stplan.api.results",
    "improve": "stplan.planner",
    "load_scene": "stplan.scene",
    "parse_scene": "stplan.scene",
    "plan": "stplan.replanning.execution",
    "plot": "stplan.api.pictures",
    "replan": "stplan.replanning.execution",
    "sample": "stplan.api.results",
    "scene_text": "stplan.api.building",
    "seed": "stplan.planner",
    "to_pandas": "stplan.api.results",
    "to_xarray": "stplan.api.results",
    "write_plan": "stplan.planner",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("stplan")
    if name == "errors":
        return import_module("stplan.errors")
    if name not in _HOMES:
        raise AttributeError(f"module 'stplan' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
