# One command file. On a fresh machine with Python 3.11 or newer, its venv module, and make:
#   make demo    checks a house on a printer, prints three layers        make setup   installs all that check and test need
#   make check   lint, types, import ranks, sizes, advisories             make test    the tests (make slow: the slow ones too)
#   make bench   timings and comparisons                                  make docs    the documentation site
#   make wheel   a wheel with compiled kernels, in dist/, for this Python and Numba, Linux and processors with AVX2
#   make release what a release consists of, in dist/release: archive of sources, wheels, notes, citation, checksums; and
#                the wheel in an empty environment, timed
#   make extras  the wheel with each extra alone, in an empty environment each, minutes
#   make fuzz    mutated files for all readers, an hour (SECONDS=60: a minute); what fails is kept in tests/fuzz_cases
#   make fuzz-server  a hundred thousand foul requests and messages to a server of its own, two minutes
#   make kills   72 commands that are killed, interrupted, without room or in company, ten minutes
#   make lock    resolves requirements/*.txt anew; the only target that installs something not pinned by hash

PYTHON ?= python3
VENV := .venv
SECONDS ?= 3600
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
CHECKED := $(wildcard src tests tools examples benchmarks)

.PHONY: demo setup check test slow fuzz fuzz-server kills bench docs wheel release extras lock clean

demo: $(VENV)/.run
	@$(BIN)/python tools/demo.py

setup: $(VENV)/.dev

check: $(VENV)/.dev
	$(BIN)/ruff check $(CHECKED)
	$(BIN)/ruff format --check $(CHECKED)
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python tools/size_report.py
	$(BIN)/python tools/branches.py --quiet
	$(BIN)/python tools/writing/words.py
	$(BIN)/codespell README.md $(CHECKED) docs Makefile
	$(BIN)/python tools/audit.py

# Hundreds of processes of the tests read the sources: compiled modules are kept, whatever the environment asks for.
# Kernels that most tests need are compiled first, each by one process: both workers would compile them at the same time.
# Tests by the clock run one after another; what loses against a busy computer is tried once more.
test slow: export PYTHONDONTWRITEBYTECODE =

test: $(VENV)/.dev
	PYTHONPATH=tests:. $(BIN)/python tests/kernels/compiled_first.py
	$(BIN)/pytest -n 2 --dist worksteal -m "not slow and not clock"
	$(BIN)/pytest tests/apps -m "clock and not slow" || \
		$(BIN)/pytest --last-failed --last-failed-no-failures none tests/apps -m "clock and not slow"

slow: $(VENV)/.dev
	PYTHONPATH=tests:. $(BIN)/python tests/kernels/compiled_first.py
	$(BIN)/pytest -n 2 --dist worksteal -m "not clock"
	$(BIN)/pytest -m "clock"

extras: $(VENV)/.dev
	rm -rf dist/extras
	$(PIP) wheel --quiet --no-deps --no-build-isolation --wheel-dir dist/extras .
	$(BIN)/python tools/release/try_extras.py dist/extras/*.whl

fuzz: $(VENV)/.dev
	$(BIN)/python tools/fuzz.py --seconds $(SECONDS)

fuzz-server: $(VENV)/.dev
	$(BIN)/python tools/fuzz_server.py --number 100000

kills: $(VENV)/.dev
	$(BIN)/python tools/kill_campaigns.py

bench: $(VENV)/.bench
	$(BIN)/python -m benchmarks.run

docs: $(VENV)/.docs
	$(BIN)/mkdocs build --strict

wheel: $(VENV)/.dev
	$(BIN)/python tools/wheel.py

release: $(VENV)/.dev
	$(BIN)/python tools/release/build.py dist/release
	$(BIN)/python tools/release/try_wheel.py $$(ls dist/release/*-linux_x86_64.whl dist/release/*-any.whl 2>/dev/null | head -1)

# A lock is installed once, and again when it changes; the package itself is linked, so its sources need no installing.
$(VENV)/.%: requirements/%.txt pyproject.toml | $(BIN)/python
	@echo "installing $< into $(VENV), once: a minute or two"
	@$(PIP) install --quiet --require-hashes --requirement $<
	@$(PIP) install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

$(BIN)/python:
	@$(PYTHON) -m venv $(VENV)

# One resolution for Linux, macOS and Windows and for every Python from 3.11. run.txt comes first and binds the others.
# UPGRADE=--upgrade takes the newest versions; without it what still fits stays.
UPGRADE ?=
COMPILE = $(VENV)/lock/bin/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --fork-strategy fewest \
	--no-emit-index-url --custom-compile-command "make lock" $(UPGRADE) pyproject.toml requirements/build.in

lock:
	$(PYTHON) -m venv $(VENV)/lock
	$(VENV)/lock/bin/python -m pip install --quiet uv
	$(COMPILE) --output-file requirements/run.txt
	$(COMPILE) --constraint requirements/run.txt --extra test --extra dev --output-file requirements/dev.txt
	$(COMPILE) --constraint requirements/dev.txt --extra docs --output-file requirements/docs.txt
	$(COMPILE) --constraint requirements/dev.txt --extra bench --output-file requirements/bench.txt

clean:
	rm -rf $(VENV) build dist site .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
