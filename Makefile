# Two commands on a fresh machine with Python 3.11 or newer, git and make:
#   make demo   analyse, differentiate and improve a real mechanism into out/demo/
#   make test   run the tests (ROOM=dynamics: those of one room)
# Both create the environment in .venv first, if it is not there or out of date.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO_STAMP := $(VENV)/.installed-demo
TEST_STAMP := $(VENV)/.installed-test
DOCS_STAMP := $(VENV)/.installed-docs
WORKERS ?= 2
# The compiler takes and gives back memory in small pieces. With this allocator, where it is
# installed, tests that compile take a tenth less processor time; it gives memory back a second after
# it became free.
ALLOCATOR := $(firstword $(wildcard /usr/lib/*/libjemalloc.so.2))
ALLOCATION := MALLOC_CONF=narenas:2,dirty_decay_ms:1000,muzzy_decay_ms:0

.PHONY: help demo test slow allocator browser versions lint bench guard docs notebooks clean

help:
	@echo "make demo       analyse and improve the actuator example into out/demo/"
	@echo "make test       run the tests, but not the slow ones; ROOM=dynamics: those of one room"
	@echo "make slow       run the slow tests; ROOM=dynamics: those of one room"
	@echo "make allocator  install an allocator that makes tests faster, where missing (as root)"
	@echo "make browser    install the browser that tests the studio, where it is missing (as root)"
	@echo "make versions   test the core paths with the lowest and the newest versions"
	@echo "make lint       ruff, pyright, and the types of public names"
	@echo "make bench      error against run time, all cases: out/bench/, and the page in docs/"
	@echo "make guard      compare errors and ratios of quick benchmarks with stored ones"
	@echo "make docs       build the documentation into out/docs/"
	@echo "make notebooks  rebuild the notebooks from their paired scripts"

$(BIN)/python:
	@echo "creating the environment in $(VENV)"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or newer is needed; set PYTHON=..."; exit 1; }
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade pip

$(DEMO_STAMP): pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing prsm_jax (this takes a minute or two the first time)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[all]'
	@touch $@

$(TEST_STAMP): pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing prsm_jax with its test tools (this takes a minute or two the first time)"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test,lint]'
	@touch $@ $(DEMO_STAMP)

$(DOCS_STAMP): pyproject.toml constraints.txt | $(BIN)/python
	@echo "installing prsm_jax with the tools of its documentation"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[all,docs]'
	@touch $@ $(DEMO_STAMP)

demo: $(DEMO_STAMP)
	@$(BIN)/prsm demo --out out/demo

# Without stored bytecode every worker and every process that a test starts translates all modules.
test: CHOICE := not slow
slow: CHOICE := slow
test slow: PRELOAD := $(if $(ALLOCATOR),LD_PRELOAD=$(ALLOCATOR) $(ALLOCATION))
# A worker keeps some memory of all programs that it compiled: several sessions of slow tests.
test: PARTS := 1/1
slow: PARTS := $(if $(ROOM),1/1,1/4 2/4 3/4 4/4)
test slow: $(TEST_STAMP)
	@failed=0; \
	for part in $(PARTS); do \
	  files=$$($(BIN)/python -m tests.of_room --part $$part $(ROOM)) || exit 2; \
	  echo "$@: part $$part: $$files"; \
	  env -u PYTHONDONTWRITEBYTECODE $(PRELOAD) \
	    $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m "$(CHOICE)" $$files || \
	    { status=$$?; test -n "$(ROOM)" -a $$status -eq 5 && echo "ROOM=$(ROOM): no such tests"; } || \
	    failed=$$status; \
	done; \
	exit $$failed

# A package of Debian's; without it the tests are the same, and slower.
allocator:
	@if test -n "$(ALLOCATOR)"; then \
	  echo "$(ALLOCATOR) is there"; \
	elif test "$$(id -u)" -eq 0 && command -v apt-get >/dev/null; then \
	  echo "installing libjemalloc2"; \
	  { apt-get -qq update && \
	    DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends install \
	      libjemalloc2; } >/dev/null || echo "it could not be installed"; \
	else \
	  echo "libjemalloc is missing: install it as root"; \
	fi

# Debian's packages. Without them the slow test of the studio is skipped, or fails where
# PRSM_TEST_BROWSER=required, as in CI.
browser:
	@if command -v chromium >/dev/null && command -v chromedriver >/dev/null; then \
	  echo "chromium and chromedriver are there"; \
	elif test "$$(id -u)" -eq 0 && command -v apt-get >/dev/null; then \
	  echo "installing chromium and chromedriver"; \
	  { apt-get -qq update && \
	    DEBIAN_FRONTEND=noninteractive apt-get -qq -y --no-install-recommends install \
	      chromium chromium-driver; } >/dev/null || echo "they could not be installed"; \
	else \
	  echo "chromium and chromedriver are missing: install them as root"; \
	fi

# The tests of the core paths with the lowest versions that pyproject.toml allows, and with the
# newest ones on other Pythons; one that is not on this machine is named as not tested.
versions: $(TEST_STAMP)
	@failed=0; \
	$(BIN)/python -m tests.versions lowest || failed=1; \
	$(BIN)/python -m tests.versions newest 3.12 3.13 || failed=1; \
	exit $$failed

# All of them, so that one that fails does not hide the others.
lint: $(TEST_STAMP)
	@failed=0; \
	$(BIN)/ruff check . || failed=1; \
	$(BIN)/ruff format --check . || failed=1; \
	$(BIN)/pyright || failed=1; \
	$(BIN)/python -m tests.layers.public_types || failed=1; \
	exit $$failed

bench: $(TEST_STAMP)
	$(BIN)/prsm bench --out out/bench --docs docs

# Exit status 1 where an error has grown tenfold or a ratio has halved.
guard: $(TEST_STAMP)
	$(BIN)/python -m benchmarks --quick --compare hertz meshing --out out/guard
	$(BIN)/python -m benchmarks joint --quick --example wu2022

# All warnings are shown; each is an error.
docs: $(DOCS_STAMP)
	$(BIN)/sphinx-build -W --keep-going -b html docs out/docs

notebooks: $(TEST_STAMP)
	$(BIN)/python notebooks/build.py

clean:
	rm -rf out .pytest_cache .ruff_cache .hypothesis
