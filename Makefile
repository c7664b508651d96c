# Two commands do everything on a fresh machine: make run, make test. The others: make help.

# An empty environment (cron, a container's entry point) has no PATH.
export PATH := $(or $(PATH),/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin)
PYTHON ?= python3
BIN := .venv/bin
SETUP := $(PYTHON) .ci/setup.py
RESULTS := demo-results
SAMPLE := sample_meshes/naca0012.su2
WITHOUT_DISPLAY := env -u DISPLAY -u WAYLAND_DISPLAY
WITHOUT_QT := PYTHONPATH=tests/blocked \
	BLOCKED_MODULES=PySide6,shiboken6,pyvistaqt,pyqtgraph,qtawesome,qtpy
PYTEST := $(BIN)/python -m pytest
BELOW_THE_WINDOW := -n 2 --ignore=tests/gui
SCREEN = $(if $(DISPLAY),,xvfb-run -a -s "-screen 0 1600x1200x24")

.PHONY: help run test headless lint types layers docs campaign bench samples pictures clean

help: ## this list
	@grep -E '^[a-z]+:.*## ' Makefile | sed 's/:.*## /\t/' | expand -t 12

run: ## set everything up and open the window (without a display: run the demo)
	@$(SETUP) gui
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
		$(BIN)/ffdstudio $(SAMPLE); \
	else \
		echo "No display here: running ffdstudio demo instead of the window."; \
		$(BIN)/ffdstudio demo -o $(RESULTS) && echo "The results lie in $(CURDIR)/$(RESULTS)"; \
	fi

test: ## set everything up and run the whole suite (without a display: under Xvfb)
	@$(SETUP) dev
	@$(SCREEN) $(PYTEST) tests/gui # one process: there is one screen, with one pointer
	@$(MAKE) --no-print-directory headless

headless: ## all tests below the window, with Qt blocked and no display
	@$(SETUP) dev
	@$(WITHOUT_DISPLAY) $(WITHOUT_QT) $(PYTEST) $(BELOW_THE_WINDOW) -p no:pytest-qt

lint: ## style (ruff)
	@$(SETUP) dev
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

types: ## mypy
	@$(SETUP) dev
	@$(BIN)/mypy

layers: ## import contracts between the rooms (import-linter)
	@$(SETUP) dev
	@$(BIN)/lint-imports

docs: ## the documentation site, into docs/_build (a warning is an error)
	@$(SETUP) docs
	@$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build

campaign: ## the slow tests (fuzzing, hostile files)
	@$(SETUP) dev
	@$(SCREEN) $(PYTEST) -m campaign -o faulthandler_timeout=7200

bench: ## every benchmark, one after the other
	@$(SETUP) bench
	@for script in benchmarks/bench_*.py; do \
		echo "== $$script"; $(BIN)/python $$script || exit 1; done

samples: ## make the sample meshes anew
	@$(SETUP) samples
	@$(BIN)/python sample_meshes/generate.py

pictures: ## make the README's pictures of the window anew
	@$(SETUP) dev
	@$(SCREEN) $(BIN)/python resources/pictures/make.py

clean: ## remove the environment, caches and results
	rm -rf .venv build dist docs/_build $(RESULTS) .pytest_cache .mypy_cache .ruff_cache \
		.hypothesis .import_linter_cache .benchmarks
	find ffdstudio tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
