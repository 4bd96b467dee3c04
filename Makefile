# make identify : the main job on the built-in twin of the paper's axis
# make test     : everything that must pass before a change lands
# PYTHON=... chooses the interpreter of the environment (3.11 or later).

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check


.DEFAULT_GOAL := help
.PHONY: help identify generate check test lint types tests lock clean

help:
	@sed -n 's/^# \(make .*\)/\1/p' Makefile

identify: $(VENV)/.run
	$(BIN)/axisid paper --output results

generate: $(VENV)/.run
	$(BIN)/axisid generate

test: lint types check tests

lint: $(VENV)/.test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

types: $(VENV)/.test
	$(BIN)/mypy

check: $(VENV)/.test
	$(BIN)/axisid generate --check

tests: $(VENV)/.test
	$(BIN)/pytest -n auto

# Rewrites the pinned and hashed requirement files; needs uv.
lock:
	uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 pyproject.toml requirements/build.in \
		-o requirements/run.txt
	uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url \
		--no-emit-find-links --python-version 3.11 --extra test pyproject.toml requirements/build.in \
		-c requirements/run.txt -o requirements/test.txt

clean:
	rm -rf $(VENV) build dist src/*.egg-info results .mypy_cache .pytest_cache .ruff_cache

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "axisid needs Python 3.11 or later; choose one with make PYTHON=python3.12" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: requirements/run.txt pyproject.toml | $(BIN)/python
	$(PIP) install --quiet --require-hashes --requirement requirements/run.txt
	$(PIP) install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/.test: requirements/test.txt $(VENV)/.run
	$(PIP) install --quiet --require-hashes --requirement requirements/test.txt
	@touch $@
