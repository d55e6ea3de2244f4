# make run, make test: each sets up everything it needs in .venv; make bench in .venv-bench
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
TOOLS := $(READY) $(VENV)/.tools
BENCH := .venv-bench

.PHONY: run test tested test-quick test-plain test-slow test-tracer test-rest test-all mutate lint style types verify bench scale docs release torture clean

run: $(READY)
	$(BIN)/clearsweep run configs/slider_crank.yaml
	$(BIN)/clearsweep report results/slider-crank-clearance

# In two processes, a file of tests in one of them, so that what a file compiles is compiled once; tests/conftest.py
# has the files that take long begin first, so that both processes end at about the same time.
SPREAD := --numprocesses 2 --dist loadfile --no-loadscope-reorder
# The loop is compiled while the tools are installed; mypy, which takes half a minute, runs beside the tests.
PAIRED := $(MAKE) --no-print-directory --jobs 2
test:
	@$(PAIRED) tested types

tested: $(TOOLS) style
	$(BIN)/python -m pytest $(SPREAD) $(if $(CHOICE),-m "$(CHOICE)")

# Leaves out what starts processes or a browser, compiles or integrates for long: `make test` before a commit.
test-quick:
	@$(PAIRED) tested types CHOICE="not slow and not plain and not heavy"

# The kernels as plain Python, and how much of them that reaches. Missing are lines that only the compiler runs.
PLAIN := $(addprefix tests/test_,$(addsuffix .py,plain bearing_profile compatible dual elastic_laws event_search \
	every_transition every_wear_law film friction_laws friction_memory karnopp laws one_block plain_scenes \
	plastic_law reynolds_film roughness shares_of_contact spread_walls tally teeth wear wear_in_space worn)) \
	tests/test_planar.py::test_accelerations_are_those_of_absolute_coordinates_with_multipliers \
	tests/test_planar.py::test_the_ideal_machine_is_the_one_without_open_joints \
	tests/test_rolling.py::test_static_position_balances_the_load
test-plain: $(TOOLS)
	$(BIN)/python -m coverage erase
	CLEARSWEEP_DISABLE_JIT=1 $(BIN)/python -m coverage run -m pytest $(SPREAD) -m "plain or not (slow or compiled)" $(PLAIN)
	$(BIN)/python -m coverage combine --quiet
	$(BIN)/python -m coverage report

# What takes minutes, compiled
test-slow: $(TOOLS)
	$(BIN)/python -m pytest $(SPREAD) -m slow

# The tracer's own tests with another release of llvmlite, by default the newest, in an environment of its own
LLVMLITE ?=
TRACER := .venv-tracer
test-tracer:
	$(PYTHON) -m venv $(TRACER)
	$(TRACER)/bin/python -m pip install --quiet --editable . pytest pytest-timeout hypothesis psutil
	$(TRACER)/bin/python -m pip install --quiet --upgrade --no-deps llvmlite$(if $(LLVMLITE),==$(LLVMLITE).*)
	$(TRACER)/bin/python -m pytest -m "not slow and not plain and not heavy" \
	  $(addprefix tests/test_,trace_bodies.py trace_functions.py trace_random.py trace_refusals.py llvm.py)

# All that `make test` leaves out
test-rest: docs test-plain test-slow

test-all: test test-rest

# ARGS: words that choose among the mutations of tests/mutate.py
mutate: $(TOOLS)
	$(BIN)/python tests/mutate.py $(ARGS)

lint: style types

style: $(VENV)/.tools
	$(BIN)/ruff check clearsweep tests
	$(BIN)/ruff format --check --quiet clearsweep tests
	$(BIN)/lint-imports

types: $(VENV)/.tools
	$(BIN)/mypy

verify: $(READY)
	$(BIN)/clearsweep verify

# ARGS: --json, --write (results/speed.md); AGAINST: a checkout of another commit, with which sweeps take turns
RUN_BENCH := PYTHONPATH=tests $(BENCH)/bin/python
WRITE = $(filter --write,$(ARGS))
bench: $(BENCH)/.ready
	@for rival in numbalsoda heyoka diffrax; do \
	  $(BENCH)/bin/python -m pip install --quiet --constraint constraints.txt --constraint tests/bench/requirements.txt \
	    $$rival >$(BENCH)/$$rival.log 2>&1 \
	  || echo "bench: $$rival does not install and is left out; $(BENCH)/$$rival.log says why" >&2; \
	done
ifdef AGAINST
	@$(RUN_BENCH) -m bench.against $(AGAINST) $(WRITE)
else
	@$(RUN_BENCH) -m bench.speed $(ARGS)
	@case "$(ARGS)" in *--json*) ;; *) $(RUN_BENCH) -m bench.ensemble $(WRITE) ;; esac
	@case "$(ARGS)" in *--json*) ;; *) $(RUN_BENCH) -m bench.taken_away $(WRITE) ;; esac
	@case "$(ARGS)" in *--json*) ;; *) $(RUN_BENCH) -m bench.machines $(WRITE) ;; esac
	@case "$(ARGS)" in *--json*) ;; *) $(RUN_BENCH) -m bench.efficiency $(WRITE) ;; esac
	@case "$(ARGS)" in *--json*) ;; *) $(RUN_BENCH) tests/bench/laws.py $(WRITE) ;; esac
	@case "$(ARGS)" in *--json*) ;; *) $(RUN_BENCH) -m bench.cold $(WRITE) ;; esac
endif

# ARGS: --made-up N,N, --real N,N, --write (N: 10000, 100000 or 1000000; results/speed.md)
scale: $(TOOLS)
	$(BIN)/python tests/scale.py $(ARGS)

$(BENCH)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(BENCH)
	$(BENCH)/bin/python -m pip install --quiet --constraint constraints.txt --editable .
	touch $@

# what is made of the code is made anew, then the site of all pages; any warning is an error
docs: $(TOOLS)
	$(BIN)/clearsweep schema --markdown >docs/grid.md
	$(BIN)/python docs/tools/columns.py
	$(BIN)/python docs/tools/rooms.py
	$(BIN)/python docs/tools/onset.py
	$(BIN)/python -m mkdocs build --quiet --strict

# the sdist and the wheel of this platform, in dist/; CLEARSWEEP_PLATFORM=linux-aarch64: of that one
release: $(TOOLS)
	$(BIN)/python -m build --no-isolation .

# ARGS: --kills N, --lives N, --grids N, --flips N, --exits N, --attempts no, --seed N, --write (docs/reliability.md)
torture: $(TOOLS)
	$(BIN)/python tests/reliability.py $(ARGS)

# Python's own code, too, so that no process that is started compiles it again; pip would compile it in one process,
# with the tests of all packages. What is no Python of this release is left.
COMPILE := $(BIN)/python -m compileall -qq -j 2 -x '/tests?/' $(VENV)/lib clearsweep || true
$(READY): $(VENV)/.installed
	$(COMPILE)
	$(BIN)/python -m clearsweep.simulation.analyses.prebuild
	touch $@

$(VENV)/.installed: pyproject.toml constraints.txt
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11))" || { echo "clearsweep needs Python 3.11 or newer, and \
	$(PYTHON) is `$(PYTHON) --version 2>&1`; give a newer one with make PYTHON=python3.12" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt --editable .
	touch $@

# what tests, checks and pages need beside what clearsweep itself does, as the installed clearsweep says
$(VENV)/.tools: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --no-compile --constraint constraints.txt "clearsweep[test]"
	$(COMPILE)
	touch $@

clean:
	rm -rf $(VENV) $(BENCH) $(TRACER) build dist site *.egg-info
