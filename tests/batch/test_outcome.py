"""The states of a run: words in summaries, exit statuses of commands, the same in every process."""

from __future__ import annotations

import json
import pickle

from stplan.batch.outcome import Outcome, RunState
from stplan.files.json_file import json_bytes


def test_a_state_is_its_word_wherever_it_is_written():
    assert RunState("no seed") is RunState.NO_SEED
    assert f"{RunState.NO_SEED}" == "no seed"
    assert json.loads(json_bytes({RunState.DIED: RunState.NO_SEED})) == {"died": "no seed"}


def test_exit_statuses_are_those_of_solving():
    statuses = {state.value: state.exit_status for state in RunState}
    assert statuses == {
        "certified": 0, "refused": 2, "no seed": 3, "failed": 4, "timeout": 4, "out of memory": 4,
        "died": 4, "error": 5, "interrupted": 130, "not run": 130,
    }  # fmt: skip


def test_outcomes_travel_between_processes():
    outcome = Outcome(RunState.TIMEOUT, ("late",), {"a.csv": b"x"}, 1.5)
    again = pickle.loads(pickle.dumps(outcome))
    assert again == outcome
    assert again.state is RunState.TIMEOUT
