"""Which linear solver is used, and what is said where the one asked for is missing."""

from __future__ import annotations

import subprocess
from dataclasses import replace

import pytest

from stplan.bench.families_open import circle
from stplan.errors import SolverError
from stplan.nlp.ipopt import linear_solvers
from stplan.nlp.ipopt.linear_solvers import chosen_linear_solver
from stplan.planner import plan


def asking_for(linear_solver, **options):
    scene = circle(3, 3.0, 10.0)
    return replace(scene, solver=replace(scene.solver, linear_solver=linear_solver, ipopt=options))


@pytest.fixture
def installed(monkeypatch):
    """Lets the probe find some solvers and crash at others; returns the calls it made."""
    linear_solvers._first_that_works.cache_clear()
    calls = []

    def install(working, crashing=()):
        def run(arguments, **named):
            *_, places = arguments[:4]
            calls.append((places, arguments[4:]))
            said = []
            for name in arguments[4:]:
                said.append(name)
                if name in crashing:
                    return subprocess.CompletedProcess(arguments, -11, "\n".join(said), "")
                if name in working:
                    said.append(name)
                    break
            return subprocess.CompletedProcess(arguments, 0, "\n".join(said), "")

        monkeypatch.setattr(subprocess, "run", run)
        return calls

    yield install
    linear_solvers._first_that_works.cache_clear()


def test_the_bundled_one_is_taken_without_a_probe(installed):
    calls = installed([])
    assert chosen_linear_solver(asking_for("mumps")) == "mumps"
    assert calls == []


def test_auto_takes_the_best_that_works_and_survives_crashes(installed):
    calls = installed(["mumps", "ma97"], crashing=["ma57", "pardisomkl"])
    assert chosen_linear_solver(asking_for(None)) == "ma97"
    assert [names[0] for _, names in calls] == ["ma57", "pardiso", "ma97"]


def test_the_probe_loads_what_the_scene_names(installed):
    calls = installed(["ma57"])
    scene = asking_for("ma57", hsllib="/opt/libcoinhsl.so", tol=1e-5)
    assert chosen_linear_solver(scene) == "ma57"
    assert calls == [('{"hsllib": "/opt/libcoinhsl.so"}', ["ma57"])]


def test_auto_finds_what_the_installed_ipopt_has():
    planned = plan(asking_for(None))
    assert planned.report.optimisation is not None
    assert planned.report.optimisation.linear_solver == "mumps"
    assert planned.certificate.holds


def test_a_missing_one_is_named_with_its_place_before_anything_else_is_done(monkeypatch):
    monkeypatch.setattr("stplan.planner.best_seeds", None)
    missing = (
        r"solver.linear_solver: the installed Ipopt cannot use 'ma57' \(it is loaded from HSL's"
    )
    with pytest.raises(SolverError, match=missing) as caught:
        plan(asking_for("ma57", hsllib="/nowhere/libhsl.so"))
    assert "mumps comes with it" in str(caught.value)
    assert caught.value.exit_status == 2


def test_an_option_that_ipopt_does_not_know_is_named():
    with pytest.raises(SolverError, match=r"solver\.ipopt\.no_such_option"):
        plan(asking_for("mumps", no_such_option=1))
