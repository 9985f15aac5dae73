"""Every cost of a plan, computed from its written files alone, in plain numpy.

Nothing here comes from the cost rooms: formulas are those of docs/method.md. The scene is read as YAML.
"""

from __future__ import annotations

import json
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml

Curves = dict[str, np.ndarray]


def recomputed_costs(folder: Path) -> dict[str, float]:
    """The costs of the run in `folder`, by the names of report.json."""
    report = json.loads((folder / "report.json").read_text())
    scene = yaml.safe_load(Path(report["scene"]["source"]).read_text())
    with np.load(folder / "trajectories.npz") as file:
        names, offsets, knots = file["agent_ids"].tolist(), file["offsets"], file["knots"]
        masses = dict(zip(names, file["masses"].tolist(), strict=True))
        radii = dict(zip(names, file["radii"].tolist(), strict=True))
        c = float(file["time_scale"])
    curves = {
        name: knots[low:high] for name, (low, high) in zip(names, pairwise(offsets), strict=True)
    }
    return BruteForce(scene, report["scales"], masses, radii, c).costs(curves)


class BruteForce:
    """Every cost of curves, each pair of segments and each edge looked at.

    Args:
        scene: as YAML gives it.
        scales: as report.json has them.
        masses, radii: by agent, kg and m.
        c: time scale, m/s.
    """

    def __init__(
        self,
        scene: dict[str, Any],
        scales: dict[str, Any],
        masses: dict[str, float],
        radii: dict[str, float],
        c: float,
    ) -> None:
        self.scene, self.masses, self.radii, self.c = scene, masses, radii, c
        self.agents = {agent["id"]: agent for agent in scene["agents"]}
        self.weigh(scales)

    def weigh(self, scales: dict[str, Any]) -> None:
        """Take other scales from now on."""
        self.scales = scales
        self.mu, self.padding = scales["mu"], scales["padding"]

    def weight(self, name: str, key: str, default: float) -> float:
        return self.agents[name].get("weights", {}).get(key, default)

    def costs(self, curves: Curves) -> dict[str, float]:
        """Every cost that the scene has, inf where something touches or is crossed."""
        self.curves = curves
        found = {"kinetic": 0.0, "regularity": 0.0}
        for name, curve in self.curves.items():
            step, dt = np.diff(curve[:, :2], axis=0), np.diff(curve[:, 2])
            energy = 0.5 * self.masses[name] * ((step**2).sum(axis=1) / dt).sum()
            found["kinetic"] += self.weight(name, "kinetic", 1.0) * energy
            even = (curve[-1, 2] - curve[0, 2]) / len(dt)
            found["regularity"] += self.scales["regularity"][name] * (even / dt).sum()
            for key, value in self._own(name, curve).items():
                found[key] = found.get(key, 0.0) + value
        for key, value in [*self._pairs(), *self._walls(), *self._meetings()]:
            found[key] = found.get(key, 0.0) + value
        return found

    def _own(self, name: str, curve: np.ndarray) -> dict[str, float]:
        agent, found = self.agents[name], {}
        if self.weight(name, "acceleration", 0.0):
            units = np.diff(curve * [1.0, 1.0, self.c], axis=0)
            units /= np.linalg.norm(units, axis=1)[:, None]
            turns = np.arccos(np.clip((units[1:] * units[:-1]).sum(axis=1), -1.0, 1.0))
            found["acceleration"] = self.weight(name, "acceleration", 0.0) * 0.5 * (turns**2).sum()
        if self.weight(name, "arrival", 0.0):
            late = curve[-1, 2] - agent["preferred_time"]
            found["arrival"] = self.weight(name, "arrival", 0.0) * 0.5 * late**2
        dt = np.diff(curve[:, 2])
        velocity = np.diff(curve[:, :2], axis=0) / dt[:, None]
        speed = np.hypot(*velocity.T)
        if "max_speed" in agent:
            found["speed limit"] = self._share(name) * self._limit(speed / agent["max_speed"], name)
        if "max_acceleration" in agent:
            change = np.hypot(*np.diff(velocity, axis=0).T) / (0.5 * (dt[1:] + dt[:-1]))
            found["acceleration limit"] = self._share(name) * self._limit(
                change / agent["max_acceleration"], name
            )
            rest = speed[[0, -1]] / (0.5 * dt[[0, -1]])
            found["rest limit"] = self._limit(rest / agent["max_acceleration"], name)
        return found

    def _share(self, name: str) -> float:
        """What one of a curve's segments weighs in a sum over them."""
        return min(1.0, self.scales["reference_segments"] / (len(self.curves[name]) - 1))

    def _segment_shares(self, name: str, count: int) -> np.ndarray:
        """Those of a rod's `count` segments: what stands on its goal weighs 1."""
        shares = np.full(count, self._share(name))
        shares[len(self.curves[name]) - 1 :] = 1.0
        return shares

    def _felt_mu(self, *names: str) -> float:
        """mu as an agent or a pair feels it: the mean of those who are free to move."""
        own = [self.scales["barrier"][name] for name in names if "path" not in self.agents[name]]
        return self.mu * float(np.prod(own)) ** (1.0 / len(own)) if own else 0.0

    def _limit(self, share: np.ndarray, *names: str) -> float:
        return self._felt_mu(*names) * sum(
            _barrier(1.0 - s**2, self.scales["limit_range"]) for s in share
        )

    def _range(self, share: str, size: float) -> float:
        given = self.scales["barrier_range"]
        if isinstance(given, dict):
            return given[share] * size
        return np.inf if given == "unbounded" else given

    def _rods(self) -> dict[str, np.ndarray]:
        last = max(
            [
                self.scene["horizon"],
                *(a["max_time"] for a in self.agents.values() if "max_time" in a),
            ]
        )
        rods = {}
        for name, curve in self.curves.items():
            rod = curve * [1.0, 1.0, self.c]
            if self.agents[name].get("after_arrival", "stay") == "stay":
                rod = np.vstack([rod, [*rod[-1, :2], self.c * last]])
            rods[name] = np.stack([rod[:-1], rod[1:]], axis=1)
        return rods

    def _pairs(self) -> list[tuple[str, float]]:
        rods, names, found = self._rods(), list(self.curves), []
        alphas = {
            (a, b): alpha for a, b, alpha in self.scales.get("pair_alphas", {}).get("rows", [])
        }
        for i, a in enumerate(names):
            for b in names[i + 1 :]:
                weights = [self.weight(name, "collision", 1.0) for name in (a, b)]
                distance, grouping = self.radii[a] + self.radii[b], 0.0
                for rule in self.scene.get("pairs", []):
                    if set(rule["between"]) == {a, b}:
                        distance = rule.get("distance", distance)
                        grouping = rule.get("grouping", grouping)
                gaps = _segment_gaps(rods[a], rods[b])
                if sum(weights) > 0.0:
                    free = gaps - distance * (1.0 + self.padding)
                    reach = self._range("share_of_distance", distance)
                    strength = self._felt_mu(a, b) * 0.5 * sum(weights)
                    alpha = alphas.get((a, b), self.scales.get("alpha_0"))
                    weights = np.outer(
                        self._segment_shares(a, len(gaps)), self._segment_shares(b, len(gaps[0]))
                    )
                    felt = self._felt(free, weights, reach, alpha)
                    found.append(("collision", strength * felt))
                    wish = max(self.agents[name].get("clearance", 0.0) for name in (a, b))
                    wished = [self.weight(name, "clearance", 1.0) for name in (a, b)]
                    missed = self._missed(gaps - distance, weights, wish)
                    if any("clearance" in agent for agent in self.agents.values()):
                        found.append(("pair clearance", 0.5 * sum(wished) * missed))
                if grouping:
                    own = gaps[: len(self.curves[a]) - 1, : len(self.curves[b]) - 1]
                    smooth = _smooth_minimum(own, self.scales["grouping_alpha"])
                    found.append(("grouping", grouping * (smooth - distance) ** 2))
        return found

    def _felt(
        self, free: np.ndarray, weights: np.ndarray, reach: float, alpha: float | None
    ) -> float:
        if alpha is not None:
            return _barrier(_smooth_minimum(free, alpha), reach)
        near = free < reach
        pairs = zip(free[near], weights[near], strict=True)
        return float(sum(weight * _barrier(one, reach) for one, weight in pairs))

    def _missed(self, free: np.ndarray, weights: np.ndarray, wish: float) -> float:
        if not wish:
            return 0.0
        unit = self.scales["energy"] / self.scales["reference_segments"]
        return unit * float((weights * np.maximum((wish - free) / wish, 0.0) ** 3).sum())

    @cached_property
    def _boundary(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges and corners of the free space."""
        room = shapely.box(*self.scene["map"]["rectangle"])
        for obstacle in self.scene["map"].get("obstacles", []):
            room = room.difference(shapely.box(*obstacle["rectangle"]))
        rings = [np.array(ring.coords) for ring in (room.exterior, *room.interiors)]
        edges = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
        corners = np.concatenate([ring[:-1] for ring in rings])
        return shapely.linestrings(edges), shapely.points(corners)

    def _walls(self) -> list[tuple[str, float]]:
        if "map" not in self.scene:
            return []
        edges, corners = self._boundary
        found = []
        for name, curve in self.curves.items():
            strength = self._felt_mu(name) * self.weight(name, "wall", 1.0)
            if strength == 0.0:
                continue
            path = shapely.linestrings(np.stack([curve[:-1, :2], curve[1:, :2]], axis=1))
            knots = shapely.points(curve[:, :2])
            gaps = np.concatenate(
                [
                    shapely.distance(knots[:, None], edges).ravel(),
                    shapely.distance(path[:, None], corners).ravel(),
                ]
            )
            radius = self.radii[name]
            free, reach = (
                gaps - radius * (1.0 + self.padding),
                self._range("share_of_radius", radius),
            )
            alpha = self.scales.get("wall_alphas", {}).get(name, self.scales.get("alpha_0"))
            weights = np.full(free.shape, self._share(name))
            crossed = shapely.intersects(path[:, None], edges).any()
            felt = np.inf if crossed else self._felt(free, weights, reach, alpha)
            found.append(("wall", strength * felt))
            missed = self._missed(gaps - radius, weights, self.agents[name].get("clearance", 0.0))
            if any("clearance" in agent for agent in self.agents.values()):
                found.append(("wall clearance", self.weight(name, "clearance", 1.0) * missed))
        return found

    def _meetings(self) -> list[tuple[str, float]]:
        found = []
        for a, i, b, j, within in self.scales.get("meetings", {}).get("rows", []):
            apart = np.hypot(*(self.curves[a][i, :2] - self.curves[b][j, :2]))
            found.append(("meeting", self._limit(np.array([apart / within]), a, b)))
        return found


def _barrier(free: float, reach: float) -> float:
    if free <= 0.0:
        return np.inf
    if np.isinf(reach):
        return -np.log(free)
    return 0.0 if free >= reach else -((1.0 - free / reach) ** 2) * np.log(free / reach)


def _smooth_minimum(values: np.ndarray, alpha: float) -> float:
    least = values.min()
    return float(least - np.log(np.exp(-alpha * (values - least)).sum()) / alpha)


def _segment_gaps(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(N, K) distances of segments (N, 2, 3) and (K, 2, 3): inside both, or at an end of one."""
    p, u = first[:, None, 0], first[:, None, 1] - first[:, None, 0]
    q, v = second[None, :, 0], second[None, :, 1] - second[None, :, 0]
    r = p - q
    # Who arrives at the very end stands there for no time at all.
    uu, vv = (np.maximum((w * w).sum(axis=-1), 1e-300) for w in (u, v))
    uv = (u * v).sum(axis=-1)
    ur, vr = (u * r).sum(axis=-1), (v * r).sum(axis=-1)
    found = []

    def gap(s: np.ndarray, t: np.ndarray) -> None:
        found.append(np.linalg.norm(r + s[..., None] * u - t[..., None] * v, axis=-1))

    for end in (0.0, 1.0):
        one = np.full(ur.shape, end)
        gap(one, np.clip((vr + end * uv) / vv, 0.0, 1.0))
        gap(np.clip((end * uv - ur) / uu, 0.0, 1.0), one)
    free = uu * vv - uv**2
    crossed = np.where(free > 1e-12 * uu * vv, free, 1.0)
    s, t = (uv * vr - vv * ur) / crossed, (uu * vr - uv * ur) / crossed
    inside = (free > 1e-12 * uu * vv) & (s > 0) & (s < 1) & (t > 0) & (t < 1)
    gap(np.where(inside, s, 0.0), np.where(inside, t, np.clip(vr / vv, 0.0, 1.0)))
    return np.min(found, axis=0)
