# The only two commands a newcomer needs: make demo, make test.
# The first of these that is there; the redirection makes make ask a shell.
PYTHON ?= $(notdir $(firstword $(foreach version,3.11 3.12 3.13, \
	$(shell command -v python$(version) 2> /dev/null)) python3))
BIN := .venv/bin
# Bytecode is kept, whatever the shell's environment says: without it every start of the
# command compiles its libraries anew, and the tests start it some hundred times.
export PYTHONDONTWRITEBYTECODE =
CORE := CMakeLists.txt $(shell find src/core -name '*.[ch]pp')
# The libraries are downloaded while the core compiles.
MAKEFLAGS += --jobs=2
unexport MAKEFLAGS
# Bytecode of all libraries takes half a minute, and most are never imported.
INSTALL := $(BIN)/pip install --quiet --no-compile
# A list of requirements of pyproject.toml, such as project.dependencies, as arguments.
REQUIRED = $$($(BIN)/python -c "import functools, sys, tomllib; \
	found = tomllib.load(open('pyproject.toml', 'rb')); \
	print(*functools.reduce(dict.get, sys.argv[1:], found))" $(1))

.PHONY: demo test style types suite sanitize benchmarks wheels site clean

demo: .venv/libraries .venv/core
	@echo "a robot that CAD has wrong, flown and identified"
	@$(BIN)/orbident demo --force
	@echo
	@echo "for the command in this shell: source $(BIN)/activate"

test: style types suite
style: .venv/tested
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run --Werror \
		$$(find src/core tests/fuzz -name '*.[ch]' -o -name '*.[ch]pp')
	$(BIN)/lint-imports
types: .venv/tested
	$(BIN)/pyright --pythonpath $(BIN)/python
# Neighbours share fixtures: they stay in one process as long as there is other work.
# Some tests have limits of time: nothing runs beside them. The annotations of every call are
# checked by pytest alone, and by the slow tests: here that would take a third of the time.
UNCHECKED := --jaxtyping-packages=none,beartype.beartype
suite: style types
	$(BIN)/pytest -n 2 --dist worksteal $(UNCHECKED)

# The tests of the numerical core under AddressSanitizer and UBSan. That there is no room for an
# array is tested too, and is no fault of a program that says so.
SANITIZED := build/sanitized/bin/python
sanitize: .venv/tested
	$(PYTHON) -m venv --without-pip build/sanitized
	echo "import site; site.addsitedir('$(CURDIR)/.venv/lib/$(PYTHON)/site-packages')" \
		> build/sanitized/lib/$(PYTHON)/site-packages/shared.pth
	$(BIN)/pip --python $(SANITIZED) install --quiet --no-deps --no-build-isolation --editable . \
		--config-settings=cmake.define.ORBIDENT_SANITIZE=ON \
		--config-settings=build-dir=build/sanitized-core
	LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libstdc++.so)" \
		ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 \
		$(SANITIZED) -m pytest -n 2 -m "core and not slow and not long" $(UNCHECKED) \
		tests/properties tests/oracles tests/unit/core tests/unit/estimation

# Every benchmark and every script of them once, with small sizes: neither timed nor judged.
benchmarks: .venv/tested
	$(BIN)/pytest -q benchmarks --benchmark-disable -o addopts="" -p no:xdist
	$(BIN)/python benchmarks/campaign_rates.py --runs 20 --duration 10
	$(BIN)/python benchmarks/long_recordings.py 20000 --tracked
	$(BIN)/python benchmarks/live_kilohertz.py --seconds 5

# The source distribution and wheels, tried in bare environments of Python 3.11 to 3.13.
wheels: .venv/tested
	.ci/wheels

# The documentation, in build/site.
site: .venv/documented
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet
	@echo "the site is in build/site"

.venv/bare:
	@command -v c++ > /dev/null || \
		{ echo "orbident needs a C++17 compiler (g++ or clang++): install one, then make again"; exit 1; }
	$(PYTHON) -m venv .venv
	touch $@

.venv/libraries: pyproject.toml | .venv/bare
	@echo "installing libraries"
	@$(INSTALL) $(call REQUIRED,project dependencies) \
		$(call REQUIRED,project optional-dependencies report)
	@touch $@

# Without isolation what is compiled stays of use: after a change only what depends on it is
# compiled again, and nothing where the same core is installed with more libraries.
.venv/core: pyproject.toml $(CORE) | .venv/bare
	@echo "compiling the core in C++: a minute or two"
	@$(INSTALL) cmake ninja $(call REQUIRED,build-system requires)
	@$(INSTALL) --no-build-isolation --no-deps --editable .
	@touch $@

.venv/documented: pyproject.toml .venv/libraries | .venv/core
	$(INSTALL) "orbident[docs]"
	touch $@

# What tests need beside.
.venv/tested: pyproject.toml .venv/libraries | .venv/core
	$(INSTALL) "orbident[test]"
	touch $@

clean:
	rm -rf .venv
