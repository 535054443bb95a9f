# make setup    environment in .venv, from requirements.lock      make check   format, lint, types, spelling, documentation
# make demo     the single blade with two dampers                 make ci      check, make test, the slow tests, parts of test-rounding and test-newest
# make test     what a change can break, seven minutes on two cores make lock    renew requirements.lock (needs uv)
# make test-all   the slow and the nightly tests too               make nightly   everything: test-all, all roundings, verify, robustness, mutants
# make test-times   the tests of make test with their processor time; one that takes more than five seconds fails
# make mutants   breaks formulas on purpose; the quick tests named in tests/mutants.toml must notice
# make mutants-drawn   breaks formulas at random, a sample of each room by a seed (SEED=1, COUNT=300), and writes docs/mutation.md; goes on where it was interrupted
# make wheel    a wheel with compiled kernels into dist/, for this system and this version of Python
# make format   mend format and lint                              make reference   renew docs/study_reference.md
# make test-oldest   a part of the tests with every dependency at its lower bound
# make test-newest   the tests of make test under the newest Python of this machine, in an environment of its own
# make test-rounding   the tests with the rounding of other processors: all of them for two, the numerical ones for the rest
# make verify   every promised number into results/verify.json and docs/verification.md, and the tests that take minutes
# make verify-system   the report in a real browser, a run of CalculiX (installs Debian's chromium and calculix-ccx where missing)
# make tutorials   carries out the tutorials and renews their pictures
# make gallery   what the examples print and draw, for the page of examples
# make paper   the figure of the first pages and of paper/paper.md
# make screenshots   the pictures of docs/explorer.md, in Chromium
# make measures   how the source is cut up: lengths of functions, helpers used once, constants, arguments
# make robustness   seeded problems, traced or the cause reported, and ill-posed ones; goes on where it was interrupted; CASES=25 of each class

PYTHON ?= python3
UV ?= uv
JOBS ?= 2
CASES ?= 250
SEED ?= 1
COUNT ?= 300
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# One BLAS thread: the dense systems are small, and contended threads slow them down.
TESTING := test test-part test-all test-times test-rounding ci nightly mutants mutants-drawn entered
$(TESTING) demo robustness: export OPENBLAS_NUM_THREADS = 1
$(TESTING): export OMP_NUM_THREADS = 1
$(TESTING): export MKL_NUM_THREADS = 1
# Compiled modules are kept, whatever the environment says: else each process of a run compiles all of them again.
$(TESTING): export PYTHONDONTWRITEBYTECODE =

# The tests of make test under the newest Python that is here, with the newest dependencies that the lock has for it; `make ci`
# runs those of the rooms that hand most to other libraries.
NEWEST = $(MAKE) VENV=build/newest PYTHON=$$($(PYTHON) tests/newest.py)
PART := tests/study tests/cli tests/results tests/runs tests/report tests/problem tests/readers tests/structure tests/physics tests/project

test-newest:
	$(NEWEST) test

# The lower bounds of pyproject.toml in an environment of their own, and what touches every dependency. Newer dependencies of
# these old packages warn; that is theirs, so warnings are no errors here.
OLDEST := build/oldest
OLDEST_TESTS := tests/study/test_faults.py tests/cli/test_cli.py tests/results tests/runs tests/report tests/structure tests/physics tests/robustness

test-oldest:
	$(PYTHON) -m venv $(OLDEST)
	$(PYTHON) tests/oldest.py > $(OLDEST)/requirements.txt
	$(OLDEST)/bin/python -m pip install -r $(OLDEST)/requirements.txt hatchling
	$(OLDEST)/bin/python -m pip install --no-deps --no-build-isolation -e .
	NUMBA_CACHE_DIR=$(CURDIR)/$(OLDEST)/kernels $(OLDEST)/bin/python -m pytest -W default -m "not verify and not system" $(OLDEST_TESTS)

.PHONY: $(TESTING) kernels entered test-newest test-oldest paper screenshots gallery tutorials setup bench wheel demo check format reference docs lock clean robustness measures verify-system verify

setup: $(STAMP)

$(STAMP): requirements.lock pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "stickslip needs Python 3.11 or newer; set PYTHON=...")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --no-deps --no-build-isolation -e .
	touch $(STAMP)

demo: setup
	$(BIN)/stickslip demo --overwrite

# A file stays in one process, so that its fixtures are computed once.
PYTEST := $(BIN)/python -m pytest -n $(JOBS) --dist loadfile --hypothesis-profile=ci
QUICK := -m "not slow and not nightly and not verify and not system"

# Compiled before the tests begin, or each of their processes compiles the same kernels: seconds where they are there already.
kernels: setup
	$(BIN)/stickslip compile

test: kernels
	$(PYTEST) $(QUICK)

test-part: kernels
	$(PYTEST) $(QUICK) $(PART)

test-all: kernels
	$(PYTEST)

test-times: kernels
	$(PYTEST) $(QUICK) --cpu-limit 5

mutants: setup
	$(BIN)/python tools/mutants.py

# What each quick test enters is recorded once; `make entered` records it again.
entered: kernels
	rm -rf results/entered
	$(PYTEST) -p tools.entered $(QUICK) --ignore=tests/runs

mutants-drawn: kernels
	test -d results/entered || $(MAKE) entered
	$(BIN)/python -m tools.drawn_mutants --seed $(SEED) --count $(COUNT)

# The kernels of the oldest processor are compiled anew: a minute of computing more, the first time.
test-rounding: setup
	$(BIN)/python tests/rounding.py all -n $(JOBS) --hypothesis-profile=ci

verify-system: setup
	command -v chromium >/dev/null || (apt-get update && apt-get install -y --no-install-recommends chromium)
	command -v ccx >/dev/null || (apt-get update && apt-get install -y --no-install-recommends calculix-ccx)
	$(BIN)/python -m pytest -m system tests/system

robustness: setup
	$(BIN)/python -m robustness.run $(CASES)

measures:
	$(PYTHON) tools/measures.py

verify: export OPENBLAS_NUM_THREADS = 1
verify: setup
	$(BIN)/python -m verify
	$(BIN)/python -m pytest -m verify

# Beside pyHarm, which goes into an environment of its own under build/; writes results/bench.json and docs/benchmarks.md.
bench: setup
	$(BIN)/python bench

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/codespell
	$(BIN)/sphinx-build -q -W --keep-going -b html docs docs/_build/html

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

reference: setup
	$(BIN)/python -m tools.reference docs/study_reference.md

wheel: setup
	$(BIN)/python -m tools.wheel

docs: setup
	$(BIN)/sphinx-build -b html docs docs/_build/html

gallery: setup
	$(BIN)/python tools/gallery.py

tutorials: setup
	$(BIN)/python tools/tutorials.py

paper: setup
	$(BIN)/python docs/figures/single_blade.py

screenshots: setup
	$(BIN)/python docs/figures/explorer.py

# While the checks run, the other processor compiles.
ci: setup
	$(MAKE) -j 2 check kernels
	$(PYTEST) -m "not nightly and not verify and not system"
	$(BIN)/python tests/rounding.py part -n $(JOBS) --dist loadfile --hypothesis-profile=ci $(QUICK)
	$(NEWEST) test-part

nightly: check test-all test-rounding test-newest verify robustness mutants

lock:
	UV_CUSTOM_COMPILE_COMMAND="make lock" $(UV) pip compile pyproject.toml --group dev --universal --python-version 3.11 \
		--generate-hashes --no-emit-index-url --no-emit-find-links --output-file requirements.lock

clean:
	rm -rf docs/_build docs/gallery .pytest_cache .mypy_cache .ruff_cache
