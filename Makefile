# make demo and make test do all of their set-up themselves, in .venv and build.
MAKEFLAGS += --no-print-directory
PYTHON ?= python3
BIN := .venv/bin
JOBS := $(shell nproc 2>/dev/null || echo 2)

.PHONY: demo test build picture lint clean

demo: build
	$(BIN)/ulna run follow --out results/follow

test: build .venv/importers
	cmake --preset sanitize -DPython3_EXECUTABLE=$(CURDIR)/$(BIN)/python
	cmake --build --preset sanitize --parallel $(JOBS)
	ctest --preset sanitize --parallel $(JOBS)
	$(BIN)/ruff check .
	$(BIN)/python -m pytest -n $(JOBS)

build: .venv/ready
	cmake --preset release -DPython3_EXECUTABLE=$(CURDIR)/$(BIN)/python
	cmake --build --preset release --parallel $(JOBS)

# the page in README.md, by Chromium
picture: demo
	$(BIN)/python tests/chromium.py results/follow/view.html examples/pictures/view.png

.venv/ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[test]' --config-settings=wheel.cmake=false
	touch $@

# Other co-simulation tools, for the tests that load our FMUs in them; those that a machine cannot
# have are named by the tests that skip.
.venv/importers: .venv/ready importers.txt
	sed 's/#.*//' importers.txt | xargs -n 1 $(BIN)/python -m pip install --quiet || true
	touch $@

clean:
	rm -rf build .venv results
