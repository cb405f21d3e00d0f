# Everything that has to hold before a change lands. CI calls `make check`; so can you.
PYTHON ?= .venv/bin/python
BIN = $(dir $(PYTHON))
# The tests to run, by pytest's marks: all. CI has already run the fast ones and asks for `slow`.
MARK ?= slow or not slow

.PHONY: check format lint types layers spelling documents tests fix

check: format lint types layers spelling documents tests

format:
	$(BIN)ruff format --check .

lint:
	$(BIN)ruff check .

types:
	$(BIN)mypy

layers:
	$(BIN)lint-imports

spelling:
	$(BIN)codespell

documents:
	$(BIN)cb validate robots programs knowledge
	$(BIN)cb fmt --check robots programs knowledge

# The slow ones run episodes on the simulator.
tests:
	$(BIN)pytest -n auto -m "$(MARK)"

fix:
	$(BIN)ruff check --fix .
	$(BIN)ruff format .
