# make demo          the main job on the default scene: a scored report in out/demo
# make test          the fast tests
# make test-slow     the others: minutes
# make test-versions the fast tests, with every Python that is declared, each in an environment of its own
# make gate          whether robust-affine got worse than its baseline, on ten small clips
# make lint          style and types
# make docs          the pages of docs/ as a site, in build/docs; a warning is an error
# make figures       pictures and tables of README and docs from kept files; with LASTS=minutes or hours, the others, too
# make coverage      the fast tests, and which lines they do not reach
# make wheel-check   a wheel, installed elsewhere, does the main job and the gate
# make clean         remove what these made
#
# The first of them makes .venv, which needs a package index; later ones work offline.
# PYTHON=/path/to/python chooses the interpreter.

.DELETE_ON_ERROR:
.SUFFIXES:
.PHONY: demo test test-slow test-versions gate lint docs figures coverage wheel-check clean install develop

VENV := .venv
BIN := $(VENV)/bin
OUT := out/demo
LASTS ?= seconds
PYTEST_OPTIONS ?= -n auto --dist worksteal
INSTALLED := $(VENV)/.installed
DEVELOPED := $(VENV)/.developed
DOCUMENTED := $(VENV)/.documented

SUPPORTED := import ensurepip, sys, venv; sys.exit(not (3, 11) <= sys.version_info[:2] < (3, 13))
CANDIDATES := python3.12 python3.11 python3
PYTHON ?= $(shell for candidate in $(CANDIDATES); do \
	"$$candidate" -c '$(SUPPORTED)' 2>/dev/null && { echo "$$candidate"; break; }; done)

demo: $(INSTALLED)
	$(BIN)/softbed run rolling_wheel $(OUT) --quick
	@echo "open $(abspath $(OUT))/report.html"

test: $(DEVELOPED)
	$(BIN)/python -m pytest $(PYTEST_OPTIONS) -m "not slow"

test-slow: $(DEVELOPED)
	$(BIN)/python -m pytest $(PYTEST_OPTIONS) -m slow

test-versions:
	for version in 3.11 3.12; do $(MAKE) test VENV=build/python$$version PYTHON=python$$version || exit 1; done

gate: $(DEVELOPED)
	$(BIN)/softbed gate --method robust-affine --baseline tests/validation/gate/robust-affine.json

lint: $(DEVELOPED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(DOCUMENTED)
	$(BIN)/python -m sphinx --builder html --quiet --fail-on-warning --keep-going docs build/docs
	@echo "open $(abspath build/docs)/index.html"

figures: $(INSTALLED)
	$(BIN)/python docs/make/figures.py $(LASTS)

coverage: $(DEVELOPED)
	$(BIN)/python -m pytest $(PYTEST_OPTIONS) -m "not slow" --cov --cov-report=term --cov-report=html:out/coverage
	@echo "open $(abspath out/coverage)/index.html"

# The folder it runs in is neither the checkout nor below it: what is missing in the wheel is missing there.
wheel-check: $(BIN)/python
	folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT && set -e && \
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps -w "$$folder" . && \
	"$(PYTHON)" -m venv "$$folder/venv" && \
	"$$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check -c constraints.txt "$$folder"/softbed-*.whl && \
	cp tests/validation/gate/robust-affine.json "$$folder" && cd "$$folder" && unset PYTHONPATH && \
	venv/bin/softbed run rolling_wheel out --quick && \
	venv/bin/softbed gate --method robust-affine --baseline robust-affine.json

install: $(INSTALLED)

develop: $(DEVELOPED)

$(BIN)/python:
	@"$(PYTHON)" -c '$(SUPPORTED)' 2>/dev/null || { \
		echo "softbed needs Python 3.11 or 3.12 with venv, tried: $(or $(PYTHON),$(CANDIDATES));" \
			"name yours with make PYTHON=/path/to/python" >&2; exit 2; }
	"$(PYTHON)" -m venv $(VENV)

$(INSTALLED): pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing into $(VENV): a minute or two, once"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e .
	@touch $@

$(DEVELOPED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

$(DOCUMENTED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	@touch $@

clean:
	rm -rf $(VENV) $(OUT) out/coverage .coverage .hypothesis .pytest_cache .ruff_cache .mypy_cache build dist
