# SPDX-License-Identifier: Apache-2.0
# make setup | demo | test | check | format | bench | fuzz | mutants | ablation | torture |
#     voxel-walk | exact-hits | materialx-pictures | fingerprint |
#     hydra | test-hydra | tsan-hydra | clean
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
MAKEFLAGS += --no-print-directory
.DELETE_ON_ERROR:
.DEFAULT_GOAL := setup

SYSTEM_PACKAGES := cmake g++ libembree-dev libgtest-dev libimath-dev libmurmurhash-dev libosd-dev \
    libtbb-dev libxxhash-dev ninja-build python3-dev python3-venv
CHECK_PACKAGES := clang-format
BENCH_PACKAGES := libllvm19

VENV := .venv
BUILD := build/release# as in pyproject.toml
PIP := $(VENV)/bin/pip --disable-pip-version-check install --quiet --constraint .ci/constraints.txt

.PHONY: setup build system-packages test test-cpp test-python check format demo bench fuzz torture \
    mutants ablation voxel-walk exact-hits materialx-pictures numerics sanitize fingerprint \
    hydra test-hydra tsan-hydra clean

## The program at .venv/bin/irt; python/ is used in place, C++ is rebuilt as far as it changed.
setup: $(VENV)/.built
build: setup

system-packages:
	@.ci/tools/install-system-packages $(SYSTEM_PACKAGES)

$(VENV)/pyvenv.cfg: | system-packages
	@.ci/tools/make-venv $(VENV)

$(VENV)/.dependencies: $(VENV)/pyvenv.cfg pyproject.toml .ci/constraints.txt
	@echo "Installing Python packages into $(VENV)"
	@$(PIP) --requirement <($(VENV)/bin/python .ci/tools/python-dependencies usd dev)
	@touch $@

# Directories are listed too: their time changes when a file comes or goes.
$(VENV)/.built: $(VENV)/.dependencies $(shell find cpp) | system-packages
	@echo "Building irt"
	@$(PIP) --no-build-isolation --no-deps --editable .
	@touch $@

test: test-cpp test-python test-hydra

$(BUILD)/.tests-built: $(VENV)/.built $(shell find tests/cpp)
	@echo "Building the C++ tests"
	@cmake -S cpp -B $(BUILD) -D IRT_BUILD_TESTS=ON >$(BUILD)/configure.log
	@cmake --build $(BUILD)
	@touch $@

test-cpp: $(BUILD)/.tests-built
	@ctest --test-dir $(BUILD) --output-on-failure --progress

# An OpenUSD of another version, which stands in for a studio's.
STUDIO_USD := build/studio-usd
$(STUDIO_USD)/.installed: $(VENV)/.dependencies
	@echo "Installing another OpenUSD into $(STUDIO_USD), to test with"
	@$(VENV)/bin/pip --disable-pip-version-check install --quiet --no-deps --upgrade \
	    --target $(STUDIO_USD) usd-core==24.11
	@touch $@

test-python: setup $(STUDIO_USD)/.installed
	@$(VENV)/bin/pytest
	@$(VENV)/bin/pytest tests/extremes

## docs/numerics.md: the extremes with all their inputs.
numerics: setup
	@mkdir -p out
	@$(VENV)/bin/pytest tests/extremes --full --report out/numerics.md
	@cat out/numerics.md

CPP_FILES = $(shell find cpp tests/cpp hydra_plugin tests/hydra -name '*.h' -o -name '*.cpp')
check: setup
	@.ci/tools/install-system-packages $(CHECK_PACKAGES)
	@clang-format --dry-run --Werror $(CPP_FILES)
	@$(VENV)/bin/ruff format --check
	@$(VENV)/bin/ruff check
	@$(VENV)/bin/mypy

format: setup
	@.ci/tools/install-system-packages $(CHECK_PACKAGES)
	@clang-format -i $(CPP_FILES)
	@$(VENV)/bin/ruff format
	@$(VENV)/bin/ruff check --fix

DEMO := shots/demo/chess.usda --size 960x540 --samples 4
IRT := $(VENV)/bin/irt
demo: setup
	@rm -rf out/demo && mkdir -p out/demo
	@$(IRT) render $(DEMO) --aov irt.retraced --output out/demo/beauty.####.exr \
	    --stats out/demo/stats.jsonl
	@$(IRT) contact-sheet out/demo/contact_sheet.png out/demo/beauty.*.exr
	@$(IRT) contact-sheet --retraced out/demo/heat_map.png out/demo/beauty.*.exr
	@echo "The same frames as full traces, to compare times:"
	@$(IRT) render $(DEMO) --aov irt.retraced --history none --quiet \
	    --output out/demo/full/beauty.####.exr --stats out/demo/full.jsonl
	@$(IRT) speedup out/demo/stats.jsonl out/demo/full.jsonl
	@$(IRT) verify $(DEMO) --json out/demo/verify.json
	@echo "Frames: out/demo/beauty.*.exr   all at a glance: out/demo/contact_sheet.png"
	@echo "What was retraced: out/demo/heat_map.png"
	@echo "Verdict: every frame equals a full trace of it, bit for bit (out/demo/verify.json)."

bench: setup
	@.ci/tools/install-system-packages $(BENCH_PACKAGES)
	@$(PIP) --requirement <($(VENV)/bin/python .ci/tools/python-dependencies bench)
	@$(VENV)/bin/python -m shots.bench.make_bench build/bench
	@DRJIT_LIBLLVM_PATH="$$(ls /usr/lib/*/libLLVM.so.19* | head -n 1)" $(VENV)/bin/irt bench trace

## Random sequences of edits until interrupted; FUZZ="--seconds 3600" ends it.
FUZZ :=
fuzz: setup
	@$(VENV)/bin/python tests/python/fuzz.py $(FUZZ)

## Jobs killed, starved and damaged until they are done; TORTURE="--runs 1000 --seed 2" for more.
TORTURE :=
torture: setup
	@$(VENV)/bin/python tests/python/torture.py $(TORTURE)

# A build of its own, whose faults and ablations (cpp/irt/mutant.h) the environment switches on.
MUTANTS := build/mutants
$(MUTANTS)/.built: $(VENV)/.built $(shell find tests/cpp)
	@echo "Building the test build of the core"
	@cmake -S cpp -B $(MUTANTS) -G Ninja -D IRT_MUTANTS=ON -D IRT_BUILD_TESTS=ON \
	    -D Python_EXECUTABLE="$(CURDIR)/$(VENV)/bin/python" \
	    -D pybind11_DIR="$$($(VENV)/bin/python -m pybind11 --cmakedir)" >$(MUTANTS).log
	@cmake --build $(MUTANTS) --target _core irt_tests
	@touch $@

## That the tests can fail: each fault must show in one of them.
mutants: $(MUTANTS)/.built
	@IRT_TEST_BUILD="$(CURDIR)/$(MUTANTS)" $(VENV)/bin/pytest tests/python/test_mutants.py -rP

# Builds of their own: $(1) names one, $(2) are its flags, $(3) is the library it is loaded with.
define sanitized
	@echo "Building the core and its tests with $(2)"
	@cmake -S cpp -B build/$(1) -G Ninja -D IRT_BUILD_TESTS=ON -D CMAKE_CXX_FLAGS="$(2)" \
	    -D Python_EXECUTABLE="$(CURDIR)/$(VENV)/bin/python" \
	    -D pybind11_DIR="$$($(VENV)/bin/python -m pybind11 --cmakedir)" >build/$(1).log
	@cmake --build build/$(1) --target _core irt_tests
	@ctest --test-dir build/$(1) --output-on-failure --progress
	@IRT_TEST_BUILD="$(CURDIR)/build/$(1)" PYTHONPATH=tests/python \
	    LD_PRELOAD="$$($(CXX) -print-file-name=$(3))" \
	    $(VENV)/bin/pytest -p core_of_test_build $(SANITIZED)
endef
SANITIZED := tests/python/test_exactness.py tests/python/test_edits.py tests/python/test_views.py
export ASAN_OPTIONS := detect_leaks=0
export UBSAN_OPTIONS := print_stacktrace=1
export TSAN_OPTIONS := ignore_noninstrumented_modules=1
## The core under the sanitizers for addresses, undefined behaviour and threads.
sanitize: setup
	$(call sanitized,sanitize-address,-fsanitize=address -fsanitize=undefined \
	    -fno-sanitize-recover=undefined,libasan.so)
	$(call sanitized,sanitize-thread,-fsanitize=thread,libtsan.so)

## What each structure is worth: the paper's edits with one of them away.
ablation: $(MUTANTS)/.built
	@IRT_TEST_BUILD="$(CURDIR)/$(MUTANTS)" $(VENV)/bin/python tests/python/ablation.py

## The paper's passing-voxel history against the key that stands for it.
voxel-walk: $(BUILD)/.tests-built
	@cmake --build $(BUILD) --target voxel_walk >$(BUILD)/voxel_walk.log
	@$(BUILD)/voxel_walk

exact-hits: $(BUILD)/.tests-built
	@$(BUILD)/exact_hits

## The pictures of docs/materialx.md, beside Mitsuba 3.
materialx-pictures: setup
	@$(VENV)/bin/python tests/python/materialx_pictures.py docs/images/materialx

fingerprint: setup
	@$(VENV)/bin/irt fingerprint

HYDRA := build/hydra
# OpenUSD is found by CMake, or is the folder HYDRA_SDK that tests/hydra/make_bpy_sdk.py makes.
HYDRA_SDK :=
PYTHON_INCLUDE = $(shell python3 -c 'import sysconfig; print(sysconfig.get_path("include"))')
PYTHON_LIBRARY = $(shell python3 -c 'import sysconfig as s; print(s.get_config_var("LIBDIR") + "/" + s.get_config_var("LDLIBRARY"))')
HYDRA_PXR = $(if $(HYDRA_SDK),-D IRT_PXR_INCLUDE_DIRS="$(HYDRA_SDK)/include;$(HYDRA_SDK)/tbb;$(PYTHON_INCLUDE)" \
    -D IRT_PXR_LIBRARIES="$(HYDRA_SDK)/lib/libusd_ms.so;$(HYDRA_SDK)/lib/libtbb.so.2;$(wildcard $(HYDRA_SDK)/lib/libboost_python*.so*);$(PYTHON_LIBRARY)")
configure-hydra = cmake -S hydra_plugin -B $(1) -G Ninja -D IRT_HYDRA_TESTS=ON $(HYDRA_PXR) $(2)

## The Hydra render delegate, in build/hydra/plugin (docs/hydra.md).
hydra: system-packages
	@$(call configure-hydra,$(HYDRA)) >$(HYDRA).log 2>&1 || { tail -n 20 $(HYDRA).log; exit 1; }
	@cmake --build $(HYDRA) --target hdIrt
	@echo "Point PXR_PLUGINPATH_NAME at $(CURDIR)/$(HYDRA)/plugin/resources"

## Skipped, and said to be, where CMake finds no OpenUSD with imaging.
test-hydra: setup
	@mkdir -p $(HYDRA)
	@if $(call configure-hydra,$(HYDRA)) >$(HYDRA).log 2>&1; then \
	    cmake --build $(HYDRA) && ctest --test-dir $(HYDRA) --output-on-failure && \
	    IRT_HYDRA_BUILD="$(CURDIR)/$(HYDRA)" $(VENV)/bin/pytest tests/hydra; \
	else \
	    echo "SKIPPED: the Hydra tests. Missing: $$(grep -m 1 -o 'Could not find.*"pxr"\|OpenUSD .*\|This OpenUSD .*' $(HYDRA).log || echo 'see $(HYDRA).log')." \
	        "Give OpenUSD 24.05 or newer by CMAKE_PREFIX_PATH, or HYDRA_SDK (docs/hydra.md)."; \
	fi

## Edits while frames are being rendered, under the threads sanitizer.
tsan-hydra: setup
	@$(call configure-hydra,$(HYDRA)-tsan,-D IRT_SANITIZE=thread -D CMAKE_BUILD_TYPE=RelWithDebInfo) >$(HYDRA)-tsan.log
	@cmake --build $(HYDRA)-tsan
	@TSAN_OPTIONS="suppressions=$(CURDIR)/tests/hydra/tsan.supp" ctest --test-dir $(HYDRA)-tsan --output-on-failure

clean:
	rm -rf build out $(VENV)
