# Works on a bare clone: the targets build the virtual environment themselves.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO := scenes/bottleneck/bottleneck.yaml

.DEFAULT_GOAL := help
.PHONY: help demo test claims check bench coverage mutation gallery docs notebooks package sessions page format clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-9s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

demo: $(VENV)/.installed ## plan five walkers through one gap, and say where the files are
	$(BIN)/stplan solve $(DEMO)
	@echo "The files are in outputs/$(basename $(notdir $(DEMO)))/; certify them once more with:"
	@echo "  $(BIN)/stplan check outputs/$(basename $(notdir $(DEMO)))"

test: $(VENV)/.installed-dev ## run the tests, on all cores
	@$(BIN)/python -m pytest -n auto --dist loadfile

claims: $(VENV)/.installed-dev ## plan every scene, large ones too, assert the paper's claims, write docs/claims.md
	@$(BIN)/python -m pytest -m "claims or not claims" tests/scenes tests/claims tests/replanning/test_rounds.py tests/explain/test_agreement.py --figures docs/claims.md

check: $(VENV)/.installed-dev ## format, lint, types, layers, then the tests: what CI runs
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	@$(MAKE) --no-print-directory test

coverage: $(VENV)/.installed-dev ## measure branch coverage of the tests, by room; fails below 92 %
	@$(BIN)/python -m pytest -n auto --dist loadfile --cov --cov-report= --cov-report=json:build/coverage.json
	@$(BIN)/python .ci/coverage_by_room.py build/coverage.json 92

mutation: $(VENV)/.installed-dev ## change the certificate's code in small ways, and see whether its tests notice
	$(BIN)/python .ci/mutation.py

bench: $(VENV)/.installed-dev ## measure the planner: small benchmarks, a few minutes
	$(BIN)/stplan bench all

format: $(VENV)/.installed-dev ## format the sources and fix what the linter can fix
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

gallery: $(VENV)/.installed-dev ## plan and draw every scene: docs/gallery and the pictures of README
	$(BIN)/python docs/make_gallery.py

docs: $(VENV)/.installed-dev ## build the site of the documentation into build/site; warnings are errors
	$(BIN)/python -m sphinx -W --keep-going -q -c docs/site -d build/doctrees docs build/site
	@echo "Open build/site/index.html"

notebooks: $(VENV)/.installed-dev ## run the notebooks and keep what they print and draw
	$(BIN)/python docs/run_notebooks.py

package: $(VENV)/.installed-dev ## build the wheel, and try it in an empty environment without the sources
	$(BIN)/python .ci/package.py

sessions: $(VENV)/.installed-dev ## three new users with the wheel and the site alone do what its tutorials say
	$(BIN)/python .ci/sessions.py

page: ## build the page of `stplan view` from its sources; needs node and npm
	cd stplan/viewing/page && npm ci --silent && npm run --silent build

clean: ## remove the virtual environment, caches and outputs
	rm -rf $(VENV) build dist *.egg-info
	rm -rf stplan/viewing/page/node_modules
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find outputs -mindepth 1 ! -name .gitkeep -delete
	find stplan tests -name __pycache__ -prune -exec rm -rf {} +

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "stplan needs Python 3.11 or newer; name one: make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); exit 1; }

# The sentinels are newer than pyproject.toml exactly when its dependencies are installed.
$(VENV)/.installed: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $(VENV)/.installed $@
