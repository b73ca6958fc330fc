# Two commands on a fresh machine: `make demo` and `make test`. Both set up .venv first.
BIN := .venv/bin
OUT ?= out
# Tests start the program many times: it is compiled once, wherever Python is told not to keep that.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: help setup demo test test-smoke test-slow test-bare test-local test-openxr random-reports test-windows explore runtime check docs audit bench torture torture-short mutants scenes clean

help:
	@echo "make demo    a complete simulated study, rendered and reported (out/demo)"
	@echo "make test    the tests, but for the slow ones"
	@echo "make test-smoke  a few of each part, in a minute"
	@echo "make test-slow   the slow ones: whole studies, rebuilt scenes, wheels, views through the lens;"
	@echo "                 and reports on odd data once more, with their figures"
	@echo "make test-local  those of published data that may not be shipped (VRCOMFORT_REFERENCE_DATA=FOLDER)"
	@echo "make test-bare   make test and test-slow on fresh Debians 12 and 13 in folders (root, 1 hour)"
	@echo "make random-reports  2,000 reports of random studies, which must not contradict themselves"
	@echo "make explore     the property tests with other, and more, examples"
	@echo "make runtime     find or make a system with a Monado runtime (OpenXR without a headset)"
	@echo "make test-openxr the tests that need one, in it"
	@echo "make test-windows  those for Windows, in a Win32 Python under Wine (root; 4 GB, made once)"
	@echo "make check   ruff, mypy --strict, import-linter"
	@echo "make docs    the documentation site (out/site)"
	@echo "make audit   known vulnerabilities of what requirements.lock names (asks osv.dev)"
	@echo "make bench   what each effect costs and how wrong it is (out/bench)"
	@echo "make torture     sessions stopped, cut off and damaged; files made worse (out/torture, an hour)"
	@echo "make torture-short   the same with few cases (4 minutes)"
	@echo "make mutants     put 300 faults into the package, and list those that no fast test notices (hours)"
	@echo "make scenes  rebuild the shipped scenes and traces"

setup:
	@scripts/setup.sh

demo: setup
	@$(BIN)/vrcomfort demo --out $(OUT)/demo

test:
	@scripts/setup.sh --tests
	@$(BIN)/pytest -q -n 3 --dist loadfile --no-loadscope-reorder -m "not slow and not monado and not needs_reference_data"

test-smoke:
	@scripts/setup.sh --tests
	@$(BIN)/pytest -q -n 2 --dist loadfile --no-loadscope-reorder -m smoke $$(grep -rl --include='test_*.py' mark.smoke tests)

test-slow:
	@scripts/setup.sh --tests --browser
	@$(BIN)/pytest -q -n 3 --dist loadfile --no-loadscope-reorder -m "slow and not monado and not needs_reference_data"
	@$(BIN)/pytest -q -n 2 --dist worksteal --draw -k "not thirty_thousand" tests/report/test_extremes.py \
		tests/report/test_notices.py tests/report/test_plan.py tests/questionnaire/test_instruments_study.py

test-bare:
	@failed=0; for suite in bookworm trixie; do \
		scripts/bare.sh $$suite make test test-slow || failed=1; done; exit $$failed

test-local:
	@scripts/setup.sh --tests
	@$(BIN)/pytest -q -m needs_reference_data

random-reports:
	@scripts/setup.sh --tests
	@VRCOMFORT_RANDOM_REPORTS=2000 $(BIN)/pytest -q -n 2 tests/report/test_random.py

explore:
	@scripts/setup.sh --tests
	@$(BIN)/pytest -q -n 2 --hypothesis-profile explore $$(grep -rl @given tests)

runtime:
	@scripts/runtime.sh

test-openxr:
	@scripts/in_runtime.sh pytest -q -n 2 --dist loadfile --no-loadscope-reorder -m monado $$(grep -rl --include='test_*.py' monado tests)

test-windows:
	@scripts/windows.sh pytest -q -p no:cacheprovider -m windows $$(grep -rl --include='test_*.py' mark.windows tests)

check: setup
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports --no-cache

docs: setup
	@$(BIN)/python scripts/frame_figure.py
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --site-dir $(abspath $(OUT))/site
	@echo "$(OUT)/site/index.html is written; vrcomfort docs opens it"

audit: setup
	@$(BIN)/python scripts/audit.py

bench: setup
	@$(BIN)/python -m bench --out $(OUT)/bench
	@$(BIN)/python -m bench.calibration --studies 200 --out $(OUT)/bench/calibration
	@$(BIN)/vrcomfort tradeoff --quick --out $(OUT)/bench/tradeoff

torture: setup
	@failed=0; $(BIN)/python -m torture --out $(OUT)/torture || failed=1; \
	scripts/in_runtime.sh python -m torture --only runtime --out $(OUT)/torture/runtime || failed=1; \
	$(BIN)/pytest -q --exposures 100 tests/headset/openxr/test_runtime_faults.py tests/headset/openxr/test_runtime_cli.py || failed=1; \
	exit $$failed

torture-short: setup
	@$(BIN)/python -m torture --short --out $(OUT)/torture
	@scripts/in_runtime.sh python -m torture --short --only runtime --out $(OUT)/torture/runtime

mutants:
	@scripts/setup.sh --tests
	@$(BIN)/python -m mutants --out $(OUT)/mutants

scenes: setup
	@$(BIN)/python scenes/build_temple.py
	@$(BIN)/python scenes/build_mountain.py
	@$(BIN)/python scenes/build_depths.py
	@$(BIN)/python scenes/build_traces.py

clean:
	rm -rf .venv $(OUT)
