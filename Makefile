# make identify : the main job on the built-in twin of the paper's axis
# make test     : lint, types, generated code, quick tests
# make studies  : the slow tests: whole identifications, and the studies of make bench in small
# make lowest   : a smoke test with the lowest versions of the required libraries
# make fuzz     : the same random inputs in numbers, from another seed; SEED=7 TIMES=100
# make docs     : the documentation, build/docs/index.html
# make bench    : how fast it is, and how often its intervals hold the truth
# PYTHON=... chooses the interpreter of the environment (3.11 or later).

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
# What is linted; files of your own beside them are left alone.
CODE := modeling codegen estimation src/axisid tests examples benchmarks docs

.DEFAULT_GOAL := help
.PHONY: help identify generate check test studies lowest fuzz bench lint types tests docs lock clean

help:
	@sed -n 's/^# \(make .*\)/\1/p' Makefile

identify: $(VENV)/.run
	$(BIN)/axisid paper --output results

generate: $(VENV)/.run
	$(BIN)/axisid generate

test: lint types check tests

# A failure prints the seed and the smallest input that fails; TIMES is that of the usual number.
SEED ?= $(shell date +%s)
TIMES ?= 50
fuzz: $(VENV)/.test
	AXISID_FUZZ_SEED=$(SEED) AXISID_FUZZ_TIMES=$(TIMES) $(BIN)/pytest -n auto tests/fuzz

# The commit that speed is measured beside.
AGAINST ?= HEAD~1
bench: $(VENV)/.test
	$(BIN)/python benchmarks/speed.py --against $(AGAINST)
	$(BIN)/python benchmarks/calibration.py
	$(BIN)/python benchmarks/library.py
	$(BIN)/python benchmarks/verdicts.py --jobs 2
	$(BIN)/python benchmarks/control_laws.py
	$(BIN)/python benchmarks/model_error.py
	$(BIN)/python benchmarks/faults.py
	$(BIN)/python benchmarks/rests.py

lint: $(VENV)/.test
	$(BIN)/ruff format --check $(CODE)
	$(BIN)/ruff check $(CODE)

types: $(VENV)/.test
	$(BIN)/mypy

check: $(VENV)/.test
	$(BIN)/axisid generate --check

# A worker for each core: linear algebra with threads of its own would only have them wait. A file's
# tests share what it makes once for all of them, so that one worker runs them.
tests studies: export OPENBLAS_NUM_THREADS ?= 1
PARALLEL := -n auto --dist loadfile
# MARKED= runs all tests.
MARKED ?= not slow
tests: $(VENV)/.test
	$(BIN)/pytest $(PARALLEL) -m "$(MARKED)"

studies: $(VENV)/.test
	$(BIN)/pytest $(PARALLEL) -m slow

# Without the libraries that only tests need; a warning is an error.
LOWEST := build/lowest
lowest: $(LOWEST)/.run
	PYTHONPATH=src $(LOWEST)/bin/python -W error tests/lowest/smoke.py
	PYTHONPATH=src $(LOWEST)/bin/python -W error -m axisid generate emps2015 --check

$(LOWEST)/.run: requirements/lowest.txt | $(BIN)/python
	$(PYTHON) -m venv --clear $(LOWEST)
	$(LOWEST)/bin/python -m pip --disable-pip-version-check install --quiet --require-hashes \
		--requirement requirements/lowest.txt
	@touch $@

# Pages that are programs are run; a warning is an error.
docs: $(VENV)/.docs
	$(BIN)/sphinx-build --fail-on-warning --keep-going --quiet --fresh-env --jobs auto docs build/docs

# Rewrites the pinned and hashed requirement files; needs uv.
lock:
	uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 pyproject.toml requirements/build.in \
		-o requirements/run.txt
	uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 --extra test pyproject.toml requirements/build.in \
		-c requirements/run.txt -o requirements/test.txt
	uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 --extra docs pyproject.toml requirements/build.in \
		-c requirements/test.txt -o requirements/docs.txt
	uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 --resolution lowest-direct pyproject.toml \
		requirements/build.in -o requirements/lowest.txt

clean:
	rm -rf $(VENV) build dist src/*.egg-info results .mypy_cache .pytest_cache .ruff_cache

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "axisid needs Python 3.11 or later; choose one with make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

ROOMS := $(shell find modeling codegen estimation src/axisid -type d ! -name __pycache__)

# The folders are listed because a strict editable install links the files that there are: it must
# be renewed when one comes or goes.
$(VENV)/.run: requirements/run.txt pyproject.toml $(ROOMS) | $(BIN)/python
	$(PIP) install --quiet --require-hashes --requirement requirements/run.txt
	$(PIP) install --quiet --no-deps --no-build-isolation --config-settings editable_mode=strict \
		--editable .
	@touch $@

$(VENV)/.test: requirements/test.txt $(VENV)/.run
	$(PIP) install --quiet --require-hashes --requirement requirements/test.txt
	@touch $@

$(VENV)/.docs: requirements/docs.txt $(VENV)/.run
	$(PIP) install --quiet --require-hashes --requirement requirements/docs.txt
	@touch $@
