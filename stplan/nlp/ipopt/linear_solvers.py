"""Which linear solver Ipopt uses: the one asked for, or the best that is there.

Ipopt can use solvers that come with it (MUMPS in the bundled one) and some that it loads when it
runs, if they are installed: HSL's from libhsl, Pardiso from libpardiso. Only trying tells.
"""

from __future__ import annotations

import json
import subprocess
import sys
from functools import lru_cache

from stplan.errors import SolverError
from stplan.scene.model import Scene

BUNDLED = "mumps"
# Best first: sparse symmetric indefinite systems of 1e3 to 1e5 unknowns, many with one structure.
PREFERENCE = ("ma57", "pardiso", "pardisomkl", "ma97", "ma86", "spral", "ma27", BUNDLED)
# Options that say where a solver is loaded from.
_PLACES = ("hsllib", "pardisolib")
_LIBRARY = {"ma": ("HSL", "libhsl", "hsllib"), "pardiso": ("Pardiso", "libpardiso", "pardisolib")}


def chosen_linear_solver(scene: Scene) -> str:
    """The solver that `solver.linear_solver` stands for in the installed Ipopt.

    Raises:
        SolverError: Ipopt cannot use the one asked for.
    """
    solver = scene.solver
    if solver.linear_solver == BUNDLED:
        return BUNDLED
    places = json.dumps({key: solver.ipopt[key] for key in _PLACES if key in solver.ipopt})
    asked = PREFERENCE if solver.linear_solver is None else (solver.linear_solver,)
    found = _first_that_works(places, asked)
    if found is None:
        message = (
            f"the installed Ipopt cannot use {asked[-1]!r}{_where(asked[-1])}; "
            f"{BUNDLED} comes with it, and auto takes the best there is"
        )
        raise SolverError(scene.located("solver.linear_solver", message))
    return found


def _where(name: str) -> str:
    """Where Ipopt would load a solver from, if it does not come with it."""
    for beginning, (owner, library, option) in _LIBRARY.items():
        if name.startswith(beginning):
            return (
                f" (it is loaded from {owner}'s {library}, which is not installed or does not fit; "
                f"solver.ipopt.{option} names another file)"
            )
    return ""


@lru_cache
def _first_that_works(places: str, names: tuple[str, ...]) -> str | None:
    """The first of `names` that Ipopt solves a small problem with; a crash counts as a no."""
    left = list(names)
    while left:
        answer = subprocess.run(
            [sys.executable, "-m", "stplan.nlp.ipopt.probe", places, *left],
            capture_output=True,
            text=True,
            check=False,
        )
        said = answer.stdout.split()
        if len(said) > 1 and said[-1] == said[-2]:
            return said[-1]
        if answer.returncode == 0 or not said:
            return None
        left = left[left.index(said[-1]) + 1 :]
    return None
