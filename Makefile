# make demo | make test: each does all the set-up it needs, in .venv.
PYTHON ?= python3
BIN := .venv/bin
STAMP := .venv/.installed

.PHONY: setup demo test check lint types layers unit audit fuzz chaos chaos-brief lock clean

setup: $(STAMP)

$(STAMP): pyproject.toml requirements.lock
	$(PYTHON) -m venv .venv
	@# uv is faster; where it cannot be had, pip does the same work. Compiled once here, not by every process of a test.
	$(BIN)/python -m pip install --quiet --disable-pip-version-check uv \
	  && $(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python -c requirements.lock -e '.[dev]' \
	  || $(BIN)/python -m pip install --quiet --disable-pip-version-check -c requirements.lock -e '.[dev]'
	touch $@

demo: setup
	@start=$$(date +%s); $(BIN)/drumtrue demo && echo "make demo: $$(($$(date +%s) - start)) s"

test: check unit

check: lint layers types

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

layers: setup
	$(BIN)/lint-imports --no-cache

types: setup
	$(BIN)/mypy

# Our own modules are compiled once for all processes, also where the environment says otherwise.
unit: export PYTHONDONTWRITEBYTECODE =
unit: setup
	@start=$$(date +%s); $(BIN)/pytest -n 3 --dist worksteal --durations=10 && echo "make unit: $$(($$(date +%s) - start)) s"

# Known vulnerabilities of the pinned dependencies; what could not be looked up is told as not checked (status 2).
audit: setup
	$(BIN)/python -m tests.audit

# A short campaign of faults on both engines; `drumtrue chaos --help` for a long one.
chaos: setup
	$(BIN)/drumtrue chaos --kills 2 --others 1
	$(BIN)/drumtrue chaos --kills 1 --others 1 --engine postgresql --replicas 2

# The least of it, for every change: one kill and, where they can be done, a full disk and a clock set back.
chaos-brief: setup
	@start=$$(date +%s); $(BIN)/drumtrue chaos --kills 1 --others 1 --within 0.2 \
	  && echo "make chaos-brief: $$(($$(date +%s) - start)) s"

# The API document with many more requests than the suite tries: about 20 minutes.
fuzz: setup
	DRUMTRUE_FUZZ_EXAMPLES=$${DRUMTRUE_FUZZ_EXAMPLES:-300} $(BIN)/pytest tests/api/test_schema.py

lock: setup
	$(BIN)/uv pip compile --universal --quiet --no-header --no-annotate --extra dev pyproject.toml -o requirements.lock

clean:
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis build dist
