# `make demo` shows it working, `make test` proves it. Both install what is missing first.
# Shared by every target: the preset's build folder is build/<preset>.
export CMAKE_CXX_COMPILER_LAUNCHER ?= $(shell command -v ccache 2>/dev/null)
JOBS ?= $(shell nproc 2>/dev/null || echo 2)
PROGRAM := build/release/bin/skinfield

.PHONY: help demo test build bench results soak format check setup clean

help:
	@echo "make demo     build, bind a sample character, leave pictures and a report in demo/"
	@echo "make test     build and run every test"
	@echo "make build    build/release/bin/skinfield"
	@echo "make check    format and tidy"
	@echo "make bench    speed"
	@echo "make results  every case of the shared data, into docs/results*.md"
	@echo "make soak     sanitizers, fuzzing, both profiles, tidy of the whole tree (long)"
	@echo "make format   reformat the sources"
	@echo "make setup    only install what is missing"

setup:
	@tools/setup.sh build validate tidy python

build:
	@tools/setup.sh build
	@tools/build.sh release -j $(JOBS)

demo:
	@tools/setup.sh build validate
	@tools/build.sh release -j $(JOBS) skinfield_cli
	@tools/demo.sh $(PROGRAM) demo

test:
	@tools/setup.sh build validate
	@tools/build.sh release -j $(JOBS)
	@tools/test.sh release -j $(JOBS)

bench:
	@tools/setup.sh build python
	@tools/build.sh release -j $(JOBS)
	@tools/bench.sh build/release

results:
	@tools/setup.sh build python
	@tools/build.sh release -j $(JOBS) skinfield_cli
	@tools/with_python.sh tools/results.py --program $(PROGRAM)
	@tools/with_python.sh tools/results_tets.py --program $(PROGRAM)
	@tools/with_python.sh tools/results_exact.py --program $(PROGRAM)
	@tools/with_python.sh tools/results_fields.py --program $(PROGRAM)
	@tools/with_python.sh tools/results_quasi.py --program $(PROGRAM)

check:
	@tools/setup.sh build tidy
	@tools/format.sh --check
	@tools/tidy.sh -j $(JOBS)

format:
	@tools/setup.sh tidy
	@tools/format.sh

soak:
	@tools/setup.sh build validate tidy fuzz
	@tools/soak.sh -j $(JOBS)

clean:
	rm -rf build demo
