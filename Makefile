# The only two commands a newcomer needs: make demo, make test.
PYTHON ?= python3.11
BIN := .venv/bin
# Bytecode is kept, whatever the shell has been told: without it every start of the
# command compiles its libraries anew, and the tests start it some hundred times.
export PYTHONDONTWRITEBYTECODE =
CORE := CMakeLists.txt $(shell find src/core -name '*.[ch]pp')

.PHONY: demo test sanitize wheels site clean

demo: .venv/installed
	$(BIN)/orbident study spatial

test: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2

# The tests of the numerical core under AddressSanitizer and UBSan.
SANITIZED := build/sanitized/bin/python
sanitize: .venv/installed
	$(PYTHON) -m venv --without-pip build/sanitized
	echo "import site; site.addsitedir('$(CURDIR)/.venv/lib/$(PYTHON)/site-packages')" \
		> build/sanitized/lib/$(PYTHON)/site-packages/shared.pth
	$(BIN)/pip --python $(SANITIZED) install --quiet --no-deps --editable . \
		--config-settings=cmake.define.ORBIDENT_SANITIZE=ON \
		--config-settings=build-dir=build/sanitized-core
	LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libstdc++.so)" ASAN_OPTIONS=detect_leaks=0 \
		$(SANITIZED) -m pytest -n 2 -m core \
		tests/properties tests/oracles tests/unit/core tests/unit/estimation

# The source distribution and wheels, tried in bare environments of Python 3.11 to 3.13.
wheels: .venv/installed
	.ci/wheels

# The documentation, in build/site.
site: .venv/installed
	$(BIN)/mkdocs build --quiet

# --no-compile: bytecode of all libraries takes half a minute, and most are never imported.
.venv/installed: pyproject.toml $(CORE)
	@command -v c++ > /dev/null || \
		{ echo "orbident needs a C++17 compiler (g++ or clang++): install one, then make again"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --no-compile --editable ".[test]"
	touch $@

clean:
	rm -rf .venv
