"""Ipopt without the rest of cyipopt, which is there all the same for whoever wants it."""

from __future__ import annotations

import subprocess
import sys


def in_a_process(program: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_the_rest_of_cyipopt_comes_when_it_is_asked_for():
    in_a_process("""
import sys
from stplan.nlp.ipopt.library import load_ipopt, package_version
ipopt = load_ipopt()
assert load_ipopt() is ipopt
version = package_version()
assert "scipy" not in sys.modules
import cyipopt
assert cyipopt.__version__ == version
assert cyipopt.Problem is ipopt.Problem
assert cyipopt.CyIpoptEvaluationError is ipopt.CyIpoptEvaluationError
assert cyipopt.exceptions.CyIpoptEvaluationError is ipopt.CyIpoptEvaluationError
assert abs(cyipopt.minimize_ipopt(lambda x: (x[0] - 1) ** 2, [3.0]).x[0] - 1.0) < 1e-6
""")


def test_whoever_imported_cyipopt_before_shares_it():
    in_a_process("""
import cyipopt
from stplan.nlp.ipopt.library import load_ipopt
assert load_ipopt().Problem is cyipopt.Problem
""")


def test_without_cyipopt_an_import_error_says_so():
    in_a_process("""
import sys
sys.modules["cyipopt"] = None
from stplan.nlp.ipopt.library import load_ipopt
try:
    load_ipopt()
except ImportError as error:
    assert "cyipopt" in str(error)
else:
    raise AssertionError
""")
