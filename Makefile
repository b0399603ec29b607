# Each target does all of its own set-up: `make demo` and `make test` are all that a fresh machine needs.

SHELL := /bin/bash
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
READY_DEV := $(VENV)/.ready-dev

.PHONY: demo test check coverage bench docs clean

## A certificate from the simulated bench; ends with its path.
demo: $(READY)
	$(BIN)/pytest --gyro-spec mems50.yaml --serial 1234
	@ls -t "$(CURDIR)"/reports/1234/*/*.pdf | head -n 1

# Two workers for two cores: threads that linear algebra would start beside them only wait for each other.
test coverage: export OPENBLAS_NUM_THREADS := 1

## Everything that must hold: format, lint, types, import contracts, tests.
test: check
	$(BIN)/python -m pytest -n 2 --dist loadscope --no-loadscope-reorder

## The tests with branch coverage, which takes half as long again; processes of their own are not counted.
coverage: $(READY_DEV)
	rm -f .coverage .coverage.*
	$(BIN)/python -m pytest -n 2 --dist loadscope --no-loadscope-reorder --cov --cov-report=term:skip-covered

check: $(READY_DEV)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

## Speed, memory and how often intervals hold the truth, beside other packages; prints the figures.
bench: $(READY_DEV)
	bash .ci/setup $(VENV) benchmark
	$(BIN)/python -m tests.benchmarks

## The pages that are generated: the reference of spec and station keys.
docs: $(READY_DEV)
	$(BIN)/gyrotest schema reference > docs/spec-reference.md

$(READY): pyproject.toml .ci/setup
	bash .ci/setup $(VENV) formats
	touch $(READY)

$(READY_DEV): pyproject.toml .ci/setup
	bash .ci/setup $(VENV) dev
	touch $(READY) $(READY_DEV)

clean:
	rm -rf $(VENV) .coverage .coverage.* .mypy_cache .ruff_cache .pytest_cache
