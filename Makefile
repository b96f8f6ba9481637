# The only commands to learn. `make` alone prints them.
# `make test PYTHON=python3.13` works beside .venv, in .venv-3.13, where .venv is of another version.
ifdef PYTHON
  VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  VENV := $(if $(wildcard .venv/lib/python*),$(if $(wildcard .venv/lib/python$(VERSION)),.venv,.venv-$(VERSION)),.venv)
else
  PYTHON := python3
  VENV := .venv
endif
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# Of all systems and versions of Python at once, with sums of the files; where they come from is each machine's own.
LOCK := $(BIN)/uv pip compile pyproject.toml --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	--custom-compile-command "make lock" $(if $(UPGRADE),--upgrade)
PYTEST := $(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal
# Tests and the programs that they start would compile all modules again.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help install web run test slow check audit fix bench mutate fuzz docs lock migration dist clean

help: ## Print this list
	@grep -E '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

$(STAMP): pyproject.toml requirements-dev.lock
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed: such as make run PYTHON=python3.13") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements-dev.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	@touch $(STAMP)

install: $(STAMP) ## Make .venv with the program and what its tests need

web: $(STAMP) ## Build the studio and the guide, where their sources changed
	@$(BIN)/python service/web/build.py

run: web ## Serve the repository on 127.0.0.1:8000, with a demo library on first start
	$(BIN)/mcml serve --demo

test: web ## Run the tests, on SQLite and PostgreSQL, and in the browser: ten minutes on two cores
	@$(BIN)/python -m tests.web.keeper install
	$(PYTEST) -m "not slow"

slow: web ## Run the tests that take seconds each: several servers, killed processes, stories in the browser
	@$(BIN)/python -m tests.web.keeper install
	$(PYTEST) -m slow

check: $(STAMP) ## Style, types, layers, spelling, plain English, the same of the studio, links of the guide, known faults of packages
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell service schemas mcml docs tests README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md
	@$(BIN)/python -m tests.docs.english
	@$(BIN)/python -m tests.web.keeper
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict --site-dir $(VENV)/guide
	@$(BIN)/python -m tests.release.audit

audit: $(STAMP) ## Ask for known faults of the packages that are locked; to be run each day
	@$(BIN)/python -m tests.release.audit --required

fix: $(STAMP) ## Mend style, and make generated files again
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	@$(BIN)/python -m tests.web.keeper fix

fuzz: $(STAMP) ## Long campaigns with new seeds: kill tests, random documents, files, requests (again: SEED=…)
	MCML_FUZZ_SEED=$(SEED) $(BIN)/python -m pytest -m "fuzz or hypothesis" --timeout=3600

mutate: $(STAMP) ## Change lines of the program, and list changes that its tests do not find (some: NAMES='mcml.motion.rotations*')
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --group mutation
	@mkdir -p mutants/service mutants/schemas # Python looks for the folders when it starts.
	PYTHONPATH=$(CURDIR)/mutants:$(CURDIR)/mutants/service:$(CURDIR)/mutants/schemas $(BIN)/mutmut run --max-children 2 $(NAMES)
	$(BIN)/mutmut results

bench: $(STAMP) ## Measure speed against named peers (installs them)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --group bench
	$(BIN)/python -m benchmarks

docs: $(STAMP) ## Make again what comes from catalogues: tables in docs/, types of the API for studio and Python; then the guide
	$(BIN)/python -m tests.docs.generate
	$(BIN)/python -m tests.docs.signatures
	@$(BIN)/ruff format --quiet mcml/client/operations.pyi
	$(BIN)/python -m tests.web.types
	$(BIN)/python service/web/build.py

lock: $(STAMP) ## Lock the versions that make install and Docker take (UPGRADE=1: the newest); each needs wheels for Python 3.11 to 3.14
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --group lock
	$(LOCK) --all-extras --group dev --output-file requirements-dev.lock
	$(LOCK) --extra server --extra cluster --extra plots --extra openid --constraint requirements-dev.lock --output-file requirements.lock
	@# A package without a wheel would need a compiler on the user's machine.
	@for version in 3.11 3.12 3.13 3.14; do \
		echo "Wheels for Python $$version"; \
		$(BIN)/uv pip install --quiet --dry-run --target $(VENV)/wheels --only-binary :all: --python-version $$version -r requirements-dev.lock || exit 1; \
	done

migration: $(STAMP) ## Make a migration from the difference of tables.py and a fresh store: make migration NAME=what_changed
	@$(BIN)/python -m tests.drills.migration "$(NAME)"

dist: $(STAMP) ## Build wheel and sdist into dist/; the version is the git tag's
	$(BIN)/python -m hatchling build

clean: ## Remove the environment and everything that is made
	rm -rf .venv .venv-* service/web/node_modules service/web/static .pytest_cache .mypy_cache .ruff_cache .hypothesis dist
