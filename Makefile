# make demo and make test set themselves up: they need Python 3.11 or newer, and make.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# Python compiles what it imports: pip would compile each file of each library, which takes half a minute.
PIP = $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
UV = $(BIN)/uv pip install --quiet --python $(BIN)/python
# uv takes a quarter of pip's time. Where the package index has none for this machine, pip installs everything.
INSTALL = $(if $(shell test -x $(BIN)/uv && echo yes),$(UV),$(PIP))
RMW ?= rmw_zenoh_cpp
PHYSICS ?= 0
comma := ,
empty :=
with = $(if $(strip $(1)),[$(subst $(empty) ,$(comma),$(strip $(1)))])
WALKS := $(filter 1,$(PHYSICS))
# With physics and the page the mission goes through the house; make demo WORLD=house does so in any case.
WORLD ?= $(if $(VIEW),$(if $(WALKS),house))
EXTRA := $(call with,$(if $(filter rmw_cyclonedds_cpp,$(RMW)),dds) $(if $(VIEW),console))
BODY := ./robot/humanoid$(call with,$(if $(WALKS),sim) $(if $(WORLD),world))
RUN := $(VENV)/.run-$(RMW)$(if $(VIEW),-view)$(if $(WALKS),-physics)$(if $(WORLD),-world)

.PHONY: dist site demo set-up test quick long fuzz lint types mypy typings bench bench-curves bench-peers bench-short checkers clean reliability zenoh-versions

# Two at once share one set-up: the second waits for the first, where there is flock.
LOCKED := $(if $(shell command -v flock 2>/dev/null),flock Makefile)
ROBOT := $(wildcard $(addprefix robot/,humanoid/setup.py humanoid/humanoid/*.py humanoid/humanoid/*/*.py humanoid_interfaces/*/* humanoid_description/*/*))

# make demo VIEW=1 shows the robot in the browser while the mission runs; PHYSICS=1 lets it walk.
demo:
	@$(LOCKED) $(MAKE) --no-print-directory set-up
	HUMANOID_PHYSICS=$(PHYSICS) RMW_IMPLEMENTATION=$(RMW) $(BIN)/humanoid demo $(if $(VIEW),--view) $(if $(WORLD),--world $(WORLD))

set-up: $(RUN)
	@:

# make test ZENOH=native (or eclipse): whose Zenoh sessions the tests and their programs open.
ifdef ZENOH
export GOALWIRE_ZENOH := $(ZENOH)
endif

# Where the tests in a browser leave their pictures.
test quick: export GOALWIRE_SCREENSHOTS ?= $(CURDIR)/build/screenshots

test: $(VENV)/.dev
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

quick: $(VENV)/.dev
	$(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder -m 'not slow'

# What takes minutes: the body on its feet, whole matrices of forks and signals, killed recorders, RTPS.
long: $(VENV)/.dev
	$(BIN)/python -m pytest -m long --durations 0

fuzz: $(VENV)/.dev
	$(INSTALL) -e '.[fuzz]'
	$(BIN)/python tests/fuzz --seconds $(or $(SECONDS),60)

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-cache

# make -j2 runs both at once.
types: mypy checkers

mypy: typings
	$(BIN)/mypy

# What most editors have. The other checkers take twice as long, and run in make long.
checkers: typings
	$(BIN)/python -m pytest -q -m long -k 'pyright or ruff' tests/checkers/test_no_false_alarms.py

typings: $(VENV)/.dev
	$(BIN)/python -m goalwire.idl.stubs typings humanoid_interfaces

bench: $(VENV)/.dev
	$(BIN)/python -m benchmarks

bench-curves: $(VENV)/.dev
	$(BIN)/python -m benchmarks --curves

# goalwire beside what else pip installs for ROS 2; --page puts the table into docs/explanation/alternatives.md.
bench-peers: $(VENV)/.dev
	$(BIN)/python -m benchmarks.peers --page

bench-short: $(VENV)/.dev
	$(BIN)/python -m benchmarks --short

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)
	@$(PIP) uv || echo 'without uv, pip installs the rest' >&2

$(RUN): pyproject.toml $(ROBOT) | $(BIN)/python
	$(INSTALL) -e '.$(EXTRA)' '$(BODY)'
	@touch $@

$(VENV)/.dev: pyproject.toml $(ROBOT) | $(BIN)/python
	$(INSTALL) -e '.[dev]' ./robot/humanoid
	@touch $@

# Every release of eclipse-zenoh from 1.5 on; some 15 s each.
zenoh-versions: $(VENV)/.dev
	$(BIN)/python tools/zenoh_versions.py

reliability: $(VENV)/.dev
	$(BIN)/python tests/reliability/report.py

# The documentation as web pages, in build/site/html: no internet is needed once .venv is there.
site: $(VENV)/.dev
	$(BIN)/python -m tools.site

# Wheel and sdist, bit for bit the same from the same files.
dist: $(VENV)/.dev
	rm -rf dist
	$(BIN)/python -m build --quiet --no-isolation

clean:
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache
