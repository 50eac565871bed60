# The only two commands a newcomer needs: make demo, make test.
PYTHON ?= python3.11
BIN := .venv/bin

.PHONY: demo test site clean

demo: .venv/installed
	$(BIN)/orbident study spatial

test: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2

# The documentation, in build/site.
site: .venv/installed
	$(BIN)/mkdocs build --quiet

.venv/installed: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --editable ".[test]"
	touch $@

clean:
	rm -rf .venv
