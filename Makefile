# make run, make test: each sets up everything it needs in .venv
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: run test test-all lint verify torture clean

run: $(READY)
	$(BIN)/clearsweep run configs/slider_crank.yaml
	$(BIN)/clearsweep report results/slider-crank-clearance

test: $(READY) lint
	$(BIN)/python -m pytest

test-all: $(READY) lint
	$(BIN)/python -m pytest -m "slow or not slow"

lint: $(READY)
	$(BIN)/ruff check clearsweep tests
	$(BIN)/lint-imports

verify: $(READY)
	$(BIN)/clearsweep verify

torture: $(READY)
	$(BIN)/python tests/torture.py

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[test]"
	touch $@

clean:
	rm -rf $(VENV) build *.egg-info
