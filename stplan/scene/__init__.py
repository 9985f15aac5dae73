"""Scenes: YAML text to a validated, immutable problem."""

from stplan.scene.format.file import scene_schema
from stplan.scene.interactions import Interactions, scene_interactions
from stplan.scene.model import Agent, Scene
from stplan.scene.reading.load import load_scene, parse_scene

__all__ = [
    "Agent",
    "Interactions",
    "Scene",
    "load_scene",
    "parse_scene",
    "scene_interactions",
    "scene_schema",
]
