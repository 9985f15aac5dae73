"""stplan: collision-free space-time trajectories for many unequal agents in tight spaces.

    import stplan

    scene = stplan.load_scene("scene.yaml")
    plan = stplan.plan(scene)

Names are loaded when first used, so that ``import stplan`` costs nothing.
"""

from __future__ import annotations

from importlib import import_module, metadata
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stplan.planner import Plan, plan
    from stplan.scene import load_scene
    from stplan.scene.model import Scene

    __version__: str

__all__ = ["Plan", "Scene", "__version__", "load_scene", "plan"]

_HOMES = {
    "Plan": "stplan.planner",
    "Scene": "stplan.scene.model",
    "load_scene": "stplan.scene",
    "plan": "stplan.planner",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return metadata.version("stplan")
    if name not in _HOMES:
        raise AttributeError(f"module 'stplan' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
