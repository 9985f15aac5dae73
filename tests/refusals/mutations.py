"""Structure-aware mutations of valid scenes, each of which is sure to break them.

A mutation takes a tree and a generator, changes the tree, and returns the path that a message has to
name, or None where it does not apply to this tree.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

from tests.refusals.case import BASES, Case, base, beside, dump

Mutation = Callable[[dict[str, Any], random.Random], str | None]
# Scenes a mutation, before those that came out equal are dropped.
DRAWS = 30

_TEXTS = ("wide", "1.0", "", "auto ", "日本", "\u202e", "a" * 2000)
_NUMBERS = (float("nan"), float("inf"), -float("inf"), 1e300, -1e10, 10**400, -(10**30))
_OPTIONAL_SIGN = {"start", "goal", "center", "start_time", "x"}


def _spots(value: Any, path: str = "") -> Iterator[tuple[Any, Any, str]]:
    """Every (container, key, path) below `value`, options of Ipopt left out."""
    if isinstance(value, dict):
        for key, inner in value.items():
            here = f"{path}.{key}" if path else key
            yield value, key, here
            yield from _spots(inner, here)
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            here = f"{path}[{index}]"
            yield value, index, here
            yield from _spots(inner, here)


def _pick(tree: Any, rng: random.Random, wanted: Callable[[Any, Any], bool]) -> Any:
    """A spot whose key and value are `wanted`, or None."""
    found = [spot for spot in _spots(tree) if wanted(spot[1], spot[0][spot[1]])]
    return rng.choice(found) if found else None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def missing_key(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A required key is gone."""
    required = {"stplan", "agents", "id", "start", "goal", "between", "center"}
    spot = _pick(tree, rng, lambda key, value: key in required)
    if "file" in spot[0]:
        return None
    del spot[0][spot[1]]
    return str(spot[2]) if spot[1] != "center" else spot[2].rpartition(".")[0]


def unknown_key(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A key is misspelt."""
    spot = _pick(tree, rng, lambda key, value: isinstance(key, str) and len(key) > 1)
    container, key, path = spot
    at = rng.randrange(len(key))
    other = rng.choice(
        [key[:at] + key[at] * 2 + key[at:], key + "_", key.upper(), f"{key} x", key[::-1]]
    )
    if other in container or other == key:
        return None
    container[other] = container.pop(key)
    return str(path[: len(path) - len(key)] + other)


def other_kind(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A value is of another kind."""
    spot = _pick(tree, rng, lambda key, value: not isinstance(value, dict | list))
    container, key, path = spot
    value = container[key]
    if isinstance(value, bool):
        choices: list[Any] = [1, "no", None, [], 0.0]
    elif isinstance(value, str):
        choices = [3, 1.5, True, None, {}, [["x"]], {"a": 1}]
    else:
        choices = [*_TEXTS, True, None, [1.0], {"a": 1}, []]
    container[key] = rng.choice(choices)
    return str(path)


def container_gone(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A list or mapping is replaced by something else."""
    spot = _pick(tree, rng, lambda key, value: isinstance(value, dict | list))
    container, key, path = spot
    swapped: Any = [] if isinstance(container[key], dict) else {}
    container[key] = rng.choice([3, None, True, 0.5, swapped])
    return str(path)


def bad_number(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A number is huge or not finite."""
    spot = _pick(tree, rng, lambda key, value: _is_number(value) and key != "barrier_range")
    spot[0][spot[1]] = rng.choice(_NUMBERS)
    return str(spot[2])


def not_positive(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A number that must be positive is not."""
    keys = {"radius", "mass", "horizon", "time_scale", "resolution", "distance", "kinetic", "wall",
            "collision", "acceleration", "grouping", "knots", "mu", "mu_decay", "alpha", "layers",
            "margin", "time_limit", "outer_iterations", "step_tolerance"}  # fmt: skip
    spot = _pick(tree, rng, lambda key, value: key in keys)
    if spot is None:
        return None
    spot[0][spot[1]] = rng.choice([-1, -0.5, -1e-300, -spot[0][spot[1]]])
    return str(spot[2])


def list_length(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A point, a knot or a rectangle has one number too few or too many."""
    spot = _pick(
        tree, rng, lambda key, value: isinstance(value, list) and value and _is_number(value[0])
    )
    numbers = spot[0][spot[1]]
    if rng.random() < 0.5:
        numbers.pop()
    else:
        numbers.append(1.0)
    return str(spot[2])


def ring(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A ring crosses itself and is not to be mended, has no area or too few corners."""
    spot = _pick(
        tree, rng,
        lambda key, value: isinstance(value, list) and len(value) >= 3
        and all(isinstance(point, list) and len(point) == 2 for point in value),
    )  # fmt: skip
    if spot is None or "waypoints" in spot[2] or "agents" in spot[2]:
        return None
    container, key, path = spot
    tree["map"]["repair"] = False
    x, y, k = rng.uniform(2, 8), rng.uniform(2, 6), rng.randint(1, 4)
    container[key] = rng.choice(
        [
            [[x, y], [x + k, y + k], [x + k, y], [x, y + k]],
            [[x, y], [x + k, y], [x + 2 * k, y]],
            [[x, y]] * 5,
            [[x, y], [x + k, y]],
            [[x, y], [x + k, y], [x + k, y + k], [x, y], [x - 1, y], [x - 1, y - 1]],
            [[x, y], [x + 4, y], [x + 4, y + 4], [x + 2, y - 2], [x, y + 4]],
        ]
    )
    return str(path)


def rectangle(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A rectangle is turned inside out or has no area."""
    spot = _pick(tree, rng, lambda key, value: key == "rectangle")
    if spot is None:
        return None
    x0, y0, x1, y1 = spot[0][spot[1]]
    spot[0][spot[1]] = rng.choice(
        [[x1, y0, x0, y1], [x0, y1, x1, y0], [x0, y0, x0, y1], [x0, y0, x1, y0], [x1, y1, x0, y0]]
    )
    return str(spot[2])


def stop_outside(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A start or goal lies outside the map, in an obstacle or too near a wall."""
    if "map" not in tree:
        return None
    agent = rng.randrange(2)
    key = rng.choice(["start", "goal"])
    if rng.random() < 0.3:
        place = [0.0, rng.uniform(0.5, 7)]
    elif rng.random() < 0.5:
        place = [rng.uniform(-50, -1), rng.uniform(-50, 50)]
    else:
        place = [rng.uniform(1, 9), rng.uniform(20, 1e8)]
    tree["agents"][agent][key] = place
    return f"agents[{agent}].{key}"


def overlap(tree: dict[str, Any], rng: random.Random) -> str | None:
    """Two agents start, or stay, in the same place."""
    key = rng.choice(["start", "goal"])
    first, second = tree["agents"][:2]
    if second.get("after_arrival") == "vanish":
        key = "start"
    if first.get("start_time"):
        second["start_time"] = first["start_time"]
    shift = rng.choice([0.0, 1e-12, 0.1, 0.3])
    second[key] = [first[key][0] + shift, first[key][1]]
    return f"agents[1].{key}"


def times(tree: dict[str, Any], rng: random.Random) -> str | None:
    """The times of an agent contradict each other."""
    agent = tree["agents"][1]
    late = agent.get("max_time", tree.get("horizon"))
    what = rng.choice(["max_time", "preferred_time", "start_time", "arrival"])
    if what == "arrival":
        agent["weights"] = {"arrival": rng.uniform(0.1, 5)}
        return "agents[1].weights.arrival"
    agent[what] = {
        "max_time": -rng.uniform(0, 9),
        "preferred_time": rng.choice([0.0, late + rng.uniform(0.1, 9)]),
        "start_time": late + rng.uniform(0, 9),
    }[what]
    return (
        "agents[1].max_time"
        if what == "start_time" and "max_time" in agent
        else f"agents[1].{what}"
    )


def pair(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A rule about pairs says nothing, or is about nobody."""
    sam, ann = (agent["id"] for agent in tree["agents"][:2])
    stranger = rng.choice(["nobody", f"{sam}x", "ALL", "*", "../..", sam.upper() + "1"])
    entry = rng.choice(
        [
            {"between": [sam, stranger], "distance": 1.0},
            {"between": [[ann, stranger], sam], "collide": False},
            {"between": [sam, sam], "distance": 1.0},
            {"between": [sam, ann]},
            {"between": [sam], "distance": 1.0},
            {"between": [sam, ann, sam], "distance": 1.0},
            {"between": [sam, []], "grouping": 1.0},
            {"between": [sam, ann], "distance": 0},
        ]
    )
    tree["pairs"] = [*tree.get("pairs", []), entry]
    return f"pairs[{len(tree['pairs']) - 1}]"


def identifier(tree: dict[str, Any], rng: random.Random) -> str | None:
    """An id is taken, reserved, or has a meaning to tables, shells or paths."""
    other = tree["agents"][0]["id"]
    tree["agents"][1]["id"] = rng.choice(
        [other, "all", "", "a b", "a,b", "a;b", "=1+1", "a\nb", "a\tb", "\u202eabc", "\u200b", "'", '"',
         "`x`", "[0]", "{a}", "a\\b", "x" * 101, "\ufeff", "a\u2028b", "\x7f", "\u00a0"]
    )  # fmt: skip
    return "agents[1].id"


def name(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A name that is no folder's, or leads out of the output folder."""
    tree["name"] = rng.choice(
        ["../x", "..", ".", "/etc/x", "a/b", "A", "", "a b", "-x", "_x", "x\n", "x\\0y",
         "~", "~root", "$HOME", "c:\\x", "日本", "x" * 101, "a/../../b", "con.txt", "%2e%2e"]
    )  # fmt: skip
    return "name"


def mesh(tree: dict[str, Any], rng: random.Random) -> str | None:
    """The mesh is no mesh beside the scene."""
    trick = rng.choice(
        ["../..", "..", ".", "/", "/etc/passwd", "/dev/zero", "/dev/stdin", "/proc/self/mem", "none.obj",
         "../../../../etc/passwd", "floor.obj/x.obj", "floor.OBJ.exe", "~/floor.obj",
         "file:///etc/passwd", "http://localhost/x.obj", "", "x" * 300 + ".obj", "a\nb.obj",
         "floor.obj\0", "//floor.obj", "*.obj", "$HOME/x.obj", "-rf.obj", "\u202ejbo.x", "none/../../x.ply"]
    )  # fmt: skip
    tree["map"] = {"mesh": trick}
    return "map.mesh"


def bases_of_the_map(tree: dict[str, Any], rng: random.Random) -> str | None:
    """No base of the map, or several, or keys that belong to another one."""
    known = [
        {"rectangle": [0, 0, 9, 9]},
        {"polygon": [[0, 0], [9, 0], [9, 9]]},
        {"mesh": "floor.obj"},
    ]
    two = rng.sample(known, 2)
    wrong: list[dict[str, Any]] = [
        {}, {**two[0], **two[1]}, {"rectangle": [0, 0, 9, 9], "up": "x"},
        {"rectangle": [0, 0, 9, 9], "holes": []}, {"resolution": rng.uniform(0.1, 1)},
        {"obstacles": []},
    ]  # fmt: skip
    tree["map"] = rng.choice(wrong)
    return "map"


def nothing_left(tree: dict[str, Any], rng: random.Random) -> str | None:
    """Obstacles cover the whole map."""
    if "map" not in tree:
        return None
    grow = rng.uniform(0, 50)
    cover: list[dict[str, Any]] = [
        {"rectangle": [-1 - grow, -1 - grow, 13 + grow, 13 + grow]},
        {"circle": {"center": [5.0, 5.0], "radius": 20 + grow}},
    ]
    tree["map"].setdefault("obstacles", []).append(rng.choice(cover))
    return "map"


def option(tree: dict[str, Any], rng: random.Random) -> str | None:
    """An option of Ipopt that is refused, or that is no option at all."""
    key, value = rng.choice(
        [("output_file", "/tmp/pwned"), ("option_file_name", "x"), ("hsllib", "./evil.so"),
         ("pardisolib", "evil.so"), ("max_iter", 3), ("linear_solver", "ma27"), ("tol", [1]),
         ("tol", None), ("tol", float("nan")), ("tol", {"a": 1}), ("print_level", 1e300),
         ("hessian_approximation", "exact"), ("mu_target", "x" * 101)]
    )  # fmt: skip
    tree.setdefault("solver", {})["ipopt"] = {key: value}
    return "solver.ipopt"


def table(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A table of agents is somewhere else, or no table."""
    if "horizon" not in tree:
        return None
    trick = rng.choice(
        ["../..", "/etc/passwd", "/dev/zero", "/proc/self/environ", "none.csv", "floor.obj", "", "x" * 300,
         "scene.yaml", "../../../../etc/shadow", "http://localhost/x.csv", "people.csv\0"]
    )  # fmt: skip
    tree["agents"].append({"file": trick, "id": "visitors"})
    return f"agents[{len(tree['agents']) - 1}].file"


def pattern(tree: dict[str, Any], rng: random.Random) -> str | None:
    """A pattern lays out nobody, too many, or all in one place."""
    entry: dict[str, Any] = rng.choice(
        [
            {"pattern": "grid", "rows": 10_000, "columns": rng.randint(1000, 10_000), "spacing": [1, 1],
             "start": [0, 0], "goal": [0, 9]},
            {"pattern": "grid", "rows": 2, "columns": 2, "spacing": [0, 0], "start": [3, 5], "goal": [0, 9]},
            {"pattern": "line", "count": 3, "start": [[0, 0], [0, 0]], "goal": [[0, 9], [9, 9]]},
            {"pattern": "line", "count": 10**9, "start": [[0, 0], [1, 0]], "goal": [[0, 9], [9, 9]]},
            {"pattern": "circle", "count": 9999, "circle": {"center": [0, 0], "radius": 1e6}},
            {"pattern": "circle", "count": 2000, "circle": {"center": [0, 0], "radius": 1}},
            {"pattern": "circle", "count": 0, "circle": {"center": [0, 0], "radius": 1}},
            {"pattern": "spiral", "count": 3}, {"pattern": ["circle"], "count": 3},
            {"pattern": "line", "count": 3, "start": [0, 0], "goal": [1, 1]},
        ]
    )  # fmt: skip
    tree["agents"].append({"id": f"p{rng.randrange(99)}", **entry})
    if entry.get("count") == 9999:
        tree["agents"].append({"id": "q", **entry})
    return "agents"


MUTATIONS: tuple[Mutation, ...] = (
    missing_key, unknown_key, other_kind, container_gone, bad_number, not_positive, list_length, ring,
    rectangle, stop_outside, overlap, times, pair, identifier, name, mesh, bases_of_the_map,
    nothing_left, option, table, pattern,
)  # fmt: skip


def cases() -> Iterator[Case]:
    """The corpus of mutated scenes, the same every time."""
    seen = set()
    for mutation in MUTATIONS:
        for draw in range(DRAWS):
            rng = random.Random(f"{mutation.__name__} {draw}")
            on = list(BASES)[draw % len(BASES)]
            tree = base(on)
            path = mutation(tree, rng)
            text = dump(tree, flow=draw % 2 == 1)
            if path is None or text in seen:
                continue
            seen.add(text)
            yield Case(f"{mutation.__name__}-{on}-{draw}", text, beside(on), path)
