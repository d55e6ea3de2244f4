# make run, make test: each sets up everything it needs in .venv; make bench in .venv-bench, make docs in .venv-docs
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
BENCH := .venv-bench
DOCS := .venv-docs

.PHONY: run test test-all lint verify bench docs torture clean

run: $(READY)
	$(BIN)/clearsweep run configs/slider_crank.yaml
	$(BIN)/clearsweep report results/slider-crank-clearance

test: $(READY) lint
	$(BIN)/python -m pytest

test-all: $(READY) lint docs
	$(BIN)/python -m pytest -m "slow or not slow"

lint: $(READY)
	$(BIN)/ruff check clearsweep tests
	$(BIN)/ruff format --check --quiet clearsweep tests
	$(BIN)/mypy
	$(BIN)/lint-imports

verify: $(READY)
	$(BIN)/clearsweep verify

# ARGS: --json, --write, --rounds N
bench: $(BENCH)/.ready
	@for rival in numbalsoda heyoka; do \
	  $(BENCH)/bin/python -m pip install --quiet --constraint constraints.txt --constraint tests/bench/requirements.txt \
	    $$rival >$(BENCH)/$$rival.log 2>&1 \
	  || echo "bench: $$rival does not install and is left out; $(BENCH)/$$rival.log says why" >&2; \
	done
	@PYTHONPATH=tests $(BENCH)/bin/python -m bench.speed $(ARGS)
	@case "$(ARGS)" in *--json*) ;; *) $(BENCH)/bin/python tests/bench/efficiency.py ;; esac

$(BENCH)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(BENCH)
	$(BENCH)/bin/python -m pip install --quiet --constraint constraints.txt --editable .
	touch $@

# what is made of the code is made anew, then the site of all pages; any warning is an error
docs: $(DOCS)/.ready
	$(DOCS)/bin/clearsweep schema --markdown >docs/grid.md
	$(DOCS)/bin/python docs/tools/columns.py
	$(DOCS)/bin/python docs/tools/rooms.py
	NO_MKDOCS_2_WARNING=1 $(DOCS)/bin/mkdocs build --quiet --strict

$(DOCS)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(DOCS)
	$(DOCS)/bin/python -m pip install --quiet --constraint constraints.txt --editable ".[docs]"
	touch $@

torture: $(READY)
	$(BIN)/python tests/torture.py

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[test]"
	touch $@

clean:
	rm -rf $(VENV) $(BENCH) $(DOCS) build site *.egg-info
