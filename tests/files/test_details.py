"""What would make a report of very many agents long is kept as arrays beside it."""

from __future__ import annotations

import io
import json

import numpy as np

from stplan.files.details import DETAILS, MOST, split_details
from stplan.files.json_file import json_bytes
from stplan.files.npz_file import arrays_bytes
from stplan.files.recorded import parse_report
from tests.files.test_recorded import HERE

MANY = MOST + 5
NAMES = [f"agent {number}" for number in range(MANY)]


def content(count: int) -> dict[str, object]:
    names = NAMES[:count]
    walls = [[name, float((7 * k) % count), None, 0.0, 0.0] for k, name in enumerate(names)]
    return {
        "status": "converged",
        "certificate": {
            "holds": True,
            "pairs": {"columns": ["a", "b", "clearance"], "rows": []},
            "walls": {"columns": ["agent", "clearance", "time", "x", "y"], "rows": walls},
            "limits": {"columns": ["agent", "reached"], "rows": [[name, 1.5] for name in names]},
        },
        "metrics": {
            "latest_arrival": 9.0,
            "agents": [{"agent": name, "length": k / 3} for k, name in enumerate(names)],
        },
        "scales": {"mu": 1.0, "barrier": {name: k / 7 for k, name in enumerate(names)}},
    }


def test_a_report_of_few_agents_stays_whole():
    given = content(MOST)
    assert split_details(given) == (given, {})


def test_every_figure_of_many_agents_is_in_the_file_that_the_report_names():
    report, arrays = split_details(content(MANY))
    assert len(json_bytes(report)) < 200 * MOST
    file = np.load(io.BytesIO(arrays_bytes(arrays)), allow_pickle=False)
    where = json.loads(json_bytes(report))["metrics"]["agents"]
    assert (where["count"], where["file"]) == (MANY, DETAILS)
    assert where["arrays"] == ["metrics.agents.agent", "metrics.agents.length"]
    assert file["metrics.agents.agent"].tolist() == NAMES
    assert file["metrics.agents.length"].tolist() == [k / 3 for k in range(MANY)]
    assert file["scales.barrier.agent"].tolist() == NAMES
    assert file["scales.barrier.value"].tolist() == [k / 7 for k in range(MANY)]
    assert file["certificate.limits.reached"].tolist() == [1.5] * MANY
    assert np.isnan(file["certificate.walls.time"]).all()
    assert report["scales"]["mu"] == 1.0


def test_the_least_clearances_stay_and_all_others_are_larger():
    report, _ = split_details(content(MANY))
    found = parse_report(report, HERE)
    assert sorted(found.clearances.values()) == [float(k) for k in range(MOST)]
    assert found.walls_above == MOST
    missing = next(name for name in NAMES if (name,) not in found.clearances)
    assert found.clearance((missing,), MOST + 2.0) == MOST + 2.0
    assert found.clearance((missing,), 3.0) == MOST
