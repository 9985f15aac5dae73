"""Universal Scene Description: a cylinder an agent that moves and turns, and walls; z upwards, m."""

from __future__ import annotations

import re

import numpy as np

from stplan.exports.settings import ExportSettings
from stplan.optional import require
from stplan.viewing.palette import agent_colours
from stplan.viewing.run_view import RunView


def usd_bytes(view: RunView, settings: ExportSettings) -> bytes:
    """A stage as text (``.usda``); a time code is a step, and names are in `displayName`."""
    usd, geometry, foundation = (
        require(f"pxr.{module}", "a USD file", "export") for module in ("Usd", "UsdGeom", "Gf")
    )
    frames = settings.frames(view)
    stage = usd.Stage.CreateInMemory()
    geometry.SetStageUpAxis(stage, geometry.Tokens.z)
    geometry.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(1.0 / frames.step)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(frames.times) - 1)
    world = geometry.Xform.Define(stage, "/World")
    stage.SetDefaultPrim(world.GetPrim())
    colours = agent_colours(view.num_agents)
    for a, name in enumerate(view.lines.agent_ids):
        path = f"/World/Agent_{a + 1}_{re.sub(r'[^A-Za-z0-9_]', '_', name)}"
        agent = geometry.Cylinder.Define(stage, path)
        agent.GetPrim().SetDisplayName(name)
        radius = float(view.radii[a])
        agent.CreateRadiusAttr(radius)
        agent.CreateHeightAttr(radius)
        agent.CreateAxisAttr(geometry.Tokens.z)
        agent.CreateDisplayColorAttr([foundation.Vec3f(*map(float, colours[a]))])
        move, turn = agent.AddTranslateOp(), agent.AddRotateZOp()
        visible = agent.CreateVisibilityAttr()
        there = ~np.isnan(frames.places[a, :, 0])
        for k in range(len(frames.times)):
            if k == 0 or there[k] != there[k - 1]:
                visible.Set(geometry.Tokens.inherited if there[k] else geometry.Tokens.invisible, k)
            if there[k]:
                x, y = frames.places[a, k].tolist()
                move.Set(foundation.Vec3d(x, y, radius / 2), k)
                turn.Set(float(np.degrees(frames.headings[a, k])), k)
    if view.free_space is not None:
        ends = view.free_space.boundary_segments.reshape(-1, 2)
        walls = geometry.BasisCurves.Define(stage, "/World/Walls")
        walls.CreateTypeAttr(geometry.Tokens.linear)
        walls.CreateCurveVertexCountsAttr([2] * (len(ends) // 2))
        walls.CreatePointsAttr([foundation.Vec3f(float(x), float(y), 0.0) for x, y in ends])
        walls.CreateWidthsAttr([0.05])
        walls.SetWidthsInterpolation(geometry.Tokens.constant)
    text: str = stage.GetRootLayer().ExportToString()
    return text.encode()
