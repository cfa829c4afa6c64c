# Everything starts here, on a machine that has Python >= 3.11 and make:
#   make design    the NREL 5-MW controller, its certificate and report, in build/nrel5mw
#   make test      all tests, except those marked slow, tex or coq
# The virtual environment is made and filled on the way; a second run finds it ready.

PYTHON ?= python3
OUT ?= build/nrel5mw
VENV := .venv
BIN := $(VENV)/bin
# What is compiled once is read by every process after it, the tests above all.
unexport PYTHONDONTWRITEBYTECODE
MEASURED := measure costs validation_plant lmi_layer lmi_growth kim_lee_ladder enclosures certificates

.DEFAULT_GOAL := help
.PHONY: help design study test marked-tests processors lint format types layers packaging bench \
        campaigns docs site check clean

help:
	@echo "make design      design, prove and report the NREL 5-MW controller in $(OUT)"
	@echo "make study       redraw the figures of both studies (7 minutes of two cores)"
	@echo "make test        run all tests (marked-tests: those that need TeX or minutes)"
	@echo "make processors  run the tests whose numbers depend on the processor as on three kinds"
	@echo "make check       lint, types and layers: what a change must pass beside the tests"
	@echo "make packaging   build the distribution and try it in a clean environment (and in those of"
	@echo "                 PYTHONS=\"python3.12 python3.13\")"
	@echo "make bench       measure the times that the documentation promises"
	@echo "make campaigns   count false verdicts, changed certificates and broken checker lines (an hour;"
	@echo "                 of the checker's lines 300 changes, drawn at random)"
	@echo "make docs        write the pages that are made from the code: conditions, published, rooms"
	@echo "make site        build the documentation as a site in build/site; a broken link is an error"
	@echo "make format      write the code as the linter wants it"
	@echo "make clean       remove all that was made, the environment included"

design: $(VENV)/.installed
	$(BIN)/takagi design nrel5mw --out $(OUT) --force

# A study that was stopped goes on where it was.
study: $(VENV)/.installed
	$(BIN)/takagi study overlap nrel5mw --out build/study-overlap
	cp build/study-overlap/figures/overlap.svg docs/figures/overlap-study.svg
	$(BIN)/pip install -q -e '.[compare]'
	$(BIN)/takagi study controllers nrel5mw --rosco all --out build/study-controllers
	cp build/study-controllers/figures/controllers.svg docs/figures/controllers-study.svg

test: $(VENV)/.installed-dev
	$(BIN)/python -m pytest --numprocesses=auto --dist=loadfile

marked-tests: $(VENV)/.installed-dev
	$(BIN)/python -m pytest -m "tex or slow or coq" --numprocesses=auto --dist=loadfile

check: lint types layers

processors: $(VENV)/.installed-dev
	.ci/processors $(BIN)/python

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: $(VENV)/.installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: $(VENV)/.installed-dev
	$(BIN)/mypy

layers: $(VENV)/.installed-dev
	cd .links && ../$(BIN)/lint-imports --config ../pyproject.toml --no-cache

packaging: $(VENV)/.installed-dev
	.ci/try-wheel $(BIN)/python $(PYTHONS)

bench: $(VENV)/.installed-bench
	@for script in $(MEASURED); do \
	    echo "$$script"; $(BIN)/python benchmarks/$$script.py || exit 1; \
	done

campaigns: $(VENV)/.installed-dev
	$(BIN)/python benchmarks/soundness.py --seed 1
	$(BIN)/python benchmarks/mutations.py --seed 1
	-$(BIN)/python benchmarks/checker_lines.py --seed 1 --count 300

docs: $(VENV)/.installed-dev
	$(BIN)/python docs/make_pages.py

site: $(VENV)/.installed-dev
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict

clean:
	rm -rf $(VENV) build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis \
	    .import_linter_cache .coverage
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Each stamp is made again when what it depends on has changed.
$(VENV)/.made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "Python >= 3.11 is needed, and $(PYTHON) is another: make PYTHON=python3.12 ..."; exit 1; }
	@$(PYTHON) -m venv $(VENV) || \
	    { echo "$(PYTHON) cannot make virtual environments: install its venv package"; exit 1; }
	@touch $@

$(VENV)/.installed: $(VENV)/.made pyproject.toml
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

# The tools of development bring the package with them, so `make design` has nothing left to do.
$(VENV)/.installed-dev: $(VENV)/.made pyproject.toml
	$(BIN)/python -m pip install --quiet --editable ".[dev]"
	@touch $(VENV)/.installed $@

# The peers that the LMI layer is measured against; a row says so when one is missing.
$(VENV)/.installed-bench: $(VENV)/.installed-dev
	$(BIN)/python -m pip install --quiet --editable ".[bench]"
	@touch $@
