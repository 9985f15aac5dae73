"""stplan: collision-free space-time trajectories for many unequal agents in tight spaces.

    import stplan

    scene = stplan.load_scene("scene.yaml")
    plan = stplan.plan(scene)

Names are loaded when first used, so that ``import stplan`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stplan import errors
    from stplan.certify.certificate import Certificate
    from stplan.planner import Plan, check, plan, seed, write_plan
    from stplan.problem.world_lines import WorldLines
    from stplan.scene import load_scene
    from stplan.scene.model import Scene

    __version__: str

__all__ = [
    "Certificate",
    "Plan",
    "Scene",
    "WorldLines",
    "__version__",
    "check",
    "errors",
    "load_scene",
    "plan",
    "seed",
    "write_plan",
]

_HOMES = {
    "Certificate": "stplan.certify.certificate",
    "Plan": "stplan.planner",
    "Scene": "stplan.scene.model",
    "WorldLines": "stplan.problem.world_lines",
    "check": "stplan.planner",
    "load_scene": "stplan.scene",
    "plan": "stplan.planner",
    "seed": "stplan.planner",
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
