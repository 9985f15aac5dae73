"""Results in the shapes that people go on with: arrays, tables of pandas, data sets of xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stplan.analysis.paths import positions
from stplan.arrays import FloatArray
from stplan.files.compare import Difference, compare_trajectories
from stplan.optional import require
from stplan.planned import Plan
from stplan.problem.world_lines import WorldLines
from stplan.scene.presence import present_until

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Curves = Plan | WorldLines


def sample(result: Curves, times: FloatArray) -> FloatArray:
    """(A, T, 2) places in m at `times` (T,) in s; NaN where an agent is not there.

    Between knots motion is straight at constant speed. In curves alone (`WorldLines`) all stay on their
    goals; of a plan those vanish that its scene says so of.

    >>> import numpy as np, stplan
    >>> lines = stplan.WorldLines.from_curves(["sam"], [np.array([[0, 0, 1], [4, 2, 3]])])
    >>> stplan.sample(lines, np.array([0.0, 1.0, 2.0, 9.0])).tolist()
    [[[nan, nan], [0.0, 0.0], [2.0, 1.0], [4.0, 2.0]]]
    """
    lines = curves_of(result)
    leaves = np.full(lines.num_agents, np.inf)
    if isinstance(result, Plan):
        agents = result.scene.agents
        stays = np.array([agent.after_arrival == "stay" for agent in agents])
        arrivals = lines.knots[lines.offsets[1:] - 1, 2]
        leaves = present_until(stays, arrivals, result.scene.final_time)
    return positions(lines, leaves, np.asarray(times, dtype=np.float64))


def to_pandas(result: Curves) -> pd.DataFrame:
    """The knots as a table with the columns agent, knot, x, y (m) and t (s): what trajectories.csv holds.

    Raises:
        UsageError: pandas is not installed (``pip install 'stplan[data]'``).

    >>> import numpy as np, stplan
    >>> lines = stplan.WorldLines.from_curves(["sam"], [np.array([[0, 0, 1], [4, 2, 3]])])
    >>> stplan.to_pandas(lines).groupby("agent").t.max().to_dict()
    {'sam': 3.0}
    """
    pandas = require("pandas", "a table of results", "data")
    lines = curves_of(result)
    counts = np.diff(lines.offsets)
    table: pd.DataFrame = pandas.DataFrame(
        {
            "agent": np.repeat(np.array(lines.agent_ids, dtype=object), counts),
            "knot": np.concatenate([np.arange(count) for count in counts]),
            "x": lines.knots[:, 0],
            "y": lines.knots[:, 1],
            "t": lines.knots[:, 2],
        }
    )
    return table


def to_xarray(result: Curves, times: FloatArray) -> xr.Dataset:
    """Places at `times` (T,) s as a data set: x and y over the dimensions agent and time.

    Raises:
        UsageError: xarray is not installed (``pip install 'stplan[data]'``).

    >>> import numpy as np, stplan
    >>> lines = stplan.WorldLines.from_curves(["sam"], [np.array([[0, 0, 1], [4, 2, 3]])])
    >>> float(stplan.to_xarray(lines, np.array([1.0, 2.0])).x.sel(agent="sam", time=2.0))
    2.0
    """
    xarray = require("xarray", "a data set of results", "data")
    places = sample(result, times)
    dimensions = ("agent", "time")
    dataset: xr.Dataset = xarray.Dataset(
        {
            "x": (dimensions, places[:, :, 0], {"units": "m"}),
            "y": (dimensions, places[:, :, 1], {"units": "m"}),
        },
        coords={
            "agent": list(curves_of(result).agent_ids),
            "time": ("time", np.asarray(times, dtype=np.float64), {"units": "s"}),
        },
    )
    return dataset


def diff(a: Curves, b: Curves, *, atol: float = 1e-9, rtol: float = 0.0) -> Difference:
    """How `b` differs from `a`, agent by agent.

    Knots agree when their distance (m) and the difference of their times (s) are at most
    ``atol + rtol * size``.

    >>> import numpy as np, stplan
    >>> lines = stplan.WorldLines.from_curves(["sam"], [np.array([[0, 0, 1], [4, 2, 3]])])
    >>> moved = lines.with_knots(lines.knots + [0, 0.5, 0])
    >>> stplan.diff(lines, lines).equal, stplan.diff(lines, moved).agents[0].position.amount
    (True, 0.5)
    """
    return compare_trajectories(curves_of(a), curves_of(b), atol, rtol)


def curves_of(result: Curves) -> WorldLines:
    """The trajectories of a plan, its seed where it has no more, or the curves themselves."""
    if isinstance(result, WorldLines):
        return result
    return result.seed if result.trajectories is None else result.trajectories
