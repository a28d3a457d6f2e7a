# Two commands matter: `make demo` and `make test`. Both install what is missing (Debian 12) and build first.
JOBS ?= $(shell nproc)
BUILD := build/release
export RELIEF_COMPILER_LAUNCHER ?= $(shell command -v ccache)

PREFIX ?= /usr/local
MANIFEST := $(DESTDIR)$(PREFIX)/share/relief/installed.txt

.PHONY: help install uninstall package setup build demo test docs bench reproduce format check fuzz asan tsan clean

help:
	@echo "make demo       encode, decode, compare and draw a real elevation model (build/demo)"
	@echo "make test       build and run all tests"
	@echo "make docs       the documentation site with a gallery and the API: build/docs/html/index.html"
	@echo "make build      build only: $(BUILD)/relief"
	@echo "make install    into PREFIX=$(PREFIX): program, library, headers, CMake package, pages; make uninstall"
	@echo "make package    a Debian package of the same, build/relief_VERSION_ARCHITECTURE.deb"
	@echo "make bench      benchmarks and the comparisons with other libraries, in one run"
	@echo "make reproduce  the source papers' numbers beside ours"
	@echo "make check      formatting, static analysis, include rule, links and examples of the documentation"
	@echo "make format     apply the formatting"
	@echo "make fuzz       fuzz every reader (needs clang); SECONDS_EACH=30"
	@echo "make asan tsan  all tests under sanitizers"

setup:
	@tools/setup

build: setup
	@cmake --preset release >/dev/null
	@cmake --build $(BUILD) -j $(JOBS)

demo: build
	@tools/demo $(BUILD) build/demo

test: build
	@tools/check_includes
	@ctest --test-dir $(BUILD) --output-on-failure -j $(JOBS)

install: build
	@cmake --install $(BUILD) --prefix $(PREFIX) >/dev/null
	@install -D -m 644 $(BUILD)/install_manifest.txt $(MANIFEST)
	@echo "installed under $(PREFIX)"

# What `make install` wrote, by its list; folders that are empty then, too.
uninstall:
	@tools/uninstall $(MANIFEST)

package: build
	@cpack -G DEB --config $(BUILD)/CPackConfig.cmake -B build >/dev/null
	@rm -rf build/_CPack_Packages
	@ls build/*.deb

docs:
	@tools/setup docs/packages.txt
	@$(MAKE) --no-print-directory build
	@tools/make_docs $(BUILD) build/docs

# Libraries that can not be installed are left out of the comparisons. BENCH=--quick, --peers, --meshes, --remesh, --points, --editor ..: see tools/bench.
bench:
	@tools/setup bench/packages.txt || true
	@$(MAKE) --no-print-directory build
	@tools/bench $(BENCH) $(BUILD) build/bench

reproduce: build
	@mkdir -p build/demo && tools/demo_dem.py build/demo/jacksboro.tif >/dev/null
	@$(BUILD)/relief-reproduce build/demo/jacksboro.tif

asan tsan: setup
	@tools/sanitize $@ $(JOBS)

SECONDS_EACH ?= 30
fuzz: setup
	@tools/fuzz $(SECONDS_EACH)

format:
	@tools/format

check: build
	@tools/format --check
	@tools/check_includes
	@tools/check_docs $(BUILD)
	@tools/tidy $(BUILD)

clean:
	rm -rf build
