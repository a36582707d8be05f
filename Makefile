# The two commands to know: `make reproduce` (into reproduction/) and `make test`. A missing .venv is made on the way.
PYTHON ?= python3.11
VENV   ?= .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
RODS   ?= 10000
SHARDS ?= 2

# One BLAS thread: the matrices are small, and a second thread makes their factorisations slower.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

.PHONY: reproduce test lint format generate fuzz mutants peers

reproduce: $(READY)
	$(BIN)/rodwnl reproduce

test: $(READY)
	$(BIN)/python -m pytest -n auto

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# Random rods, float64 against exact; rods that random-rods/ holds already are not computed again.
fuzz: $(READY)
	seq $(SHARDS) | xargs -P $(SHARDS) -I{} $(BIN)/python -m rodwnl.agreement --count $(RODS) --shard {}/$(SHARDS)
	$(BIN)/python -m rodwnl.agreement --count 0

# Errors of the kinds that people make, in every equation of the paper: the ledger must see each.
mutants: $(READY)
	$(BIN)/python -m derivation.paper.mutants

# Tools that others wrote, each in an environment of its own: their threshold, frequency and slopes.
peers: $(READY) .peers/jaxcont/.ready .peers/pyoomph/.ready
	$(BIN)/python peers/compare.py

.peers/%/.ready: peers/%.txt
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	touch $@

generate: $(READY)
	$(BIN)/rodwnl derive

# Stamped last, so that an interrupted installation is started again.
$(READY): pyproject.toml
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[all]'
	touch $@
