# make study: set up, build, run the study; make test: set up, build, run the tests. See README.md.
COHORT ?= nine
CASES ?=
N ?= 1000
SEED ?= 1
FUZZ_SECONDS ?= 60
CORES ?= $(shell env -u OMP_NUM_THREADS nproc)
BUILD ?= build
PYTHON := /usr/bin/python3
SNAKEMAKE := /usr/bin/snakemake
REPORT := results/report/index.html
FAILED := results/study/failed.json
STUDY_OPTIONS = --profile config/profiles/local --cores $(CORES) --config cohort=$(COHORT) $(if $(CASES),cases='$(CASES)')
RUN_STUDY = $(SNAKEMAKE) $(STUDY_OPTIONS)

.DEFAULT_GOAL := study
.PHONY: setup build validate study best-plans manifest verify cohort faults unlock test test-cpp test-python sanitize fuzz lint format docs clean help

help: ## show this list
	@grep -E '^[a-z-]+:.*##' Makefile | sed 's/:.*##/ -/'

setup: ## install the Debian packages that are missing
	@setup/install.sh

$(BUILD)/build.ninja: CMakeLists.txt | setup
	cmake -S . -B $(BUILD) -G Ninja -DCMAKE_BUILD_TYPE=Release

$(BUILD)/three.min.js: $(wildcard reports/page/three/*) | setup
	@mkdir -p $(BUILD)
	reports/page/three/bundle.sh $@

build: setup $(BUILD)/build.ninja $(BUILD)/three.min.js ## compile programs and Python module, bundle the page's viewer, into build/
	@ninja -C $(BUILD) -j $(CORES) vci lumen vci_python flow_factors

validate: setup ## check every configuration file
	@$(PYTHON) -m workflow validate

study: build ## run a cohort (COHORT=nine|three|quick|contrast|pressures|hard|real) or single cases (CASES="lad01 rca01"); -j by CORES
	@began=$$(date +%s); $(RUN_STUDY) || { \
	  if [ -n "$$(ls -A .snakemake/locks 2>/dev/null)" ]; then \
	    echo "the folder is locked: another run works in it, or one was killed; if none runs any more: make unlock" >&2; \
	  elif $(PYTHON) -m workflow failed --since $$began --out $(FAILED) && $(RUN_STUDY) failed=$(FAILED); then \
	    echo "$(REPORT) is the page of the other cases; it says what failed" >&2; exit 1; \
	  fi; \
	  [ ! -f $(REPORT) ] || echo "$(REPORT) is the page of an earlier run" >&2; exit 1; }
	@echo "report: $(REPORT)"

best-plans: build ## after `make study`: flow in three dimensions of the two best plans of each case, then the report
	@$(SNAKEMAKE) best_plans $(STUDY_OPTIONS)
	@$(MAKE) --no-print-directory study

manifest: ## write what a finished study must give again on any machine, config/manifests/COHORT.json
	@$(PYTHON) -m workflow manifest --out config/manifests/$(COHORT).json

verify: ## compare a finished study with the manifest that ships, config/manifests/COHORT.json
	@$(PYTHON) -m workflow verify --manifest config/manifests/$(COHORT).json

cohort: build ## draw N patients of SEED, run them in shards by the reduced flow, and tabulate them (results/cohort)
	@$(PYTHON) -m workflow cohort --count $(N) --seed $(SEED) --cores $(CORES) --out results/cohort/seed$(SEED)
	@$(PYTHON) -m reports subgroups --cohort results/cohort/seed$(SEED) --out results/cohort/seed$(SEED)

faults: build ## kill a small study, fill its disk and so on, resume it, compare bits; writes docs/faults.md
	@$(PYTHON) tests/faults/run.py --out results/faults --page docs/faults.md

unlock: ## after a run that was killed (power cut, kill -9): let the next one go on from there
	@$(SNAKEMAKE) --unlock --cores 1

test: lint test-cpp test-python ## all tests but the slow ones: formatting, C++, Python units, verification, refusals

test-cpp: build
	@ninja -C $(BUILD) -j $(CORES)
	@mkdir -p results/tests
	ctest --test-dir $(BUILD) --output-on-failure -j $(CORES) --output-junit $(CURDIR)/results/tests/cpp.xml

# The anatomy is left out: with sanitizers CGAL's headers take longer to compile than all else together. -O1 compiles in
# half the time of -O2. NDEBUG is not defined, so that Eigen's assertions are checked too.
sanitize: setup ## C++ unit tests and a short fuzz of the deployment engine with the address and undefined-behaviour sanitizers
	@[ -f build-sanitize/build.ninja ] || cmake -S . -B build-sanitize -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
	  -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" -DVCI_SANITIZE=ON
	@ninja -C build-sanitize -j $(CORES) vci vci_unit_tests vci_verification_tests \
	  vci_fuzz_scene vci_fuzz_lumen vci_fuzz_centreline
	ctest --test-dir build-sanitize --exclude-regex NOT_BUILT --output-on-failure -j $(CORES) --quiet
	VCI_BUILD_DIR=build-sanitize VCI_FUZZ_MUTANTS=6 OMP_NUM_THREADS=1 $(PYTHON) -m pytest -q \
	  tests/verification/vci/test_fuzz.py tests/verification/vci/test_fuzz_targets.py

fuzz: setup ## fuzz the readers for FUZZ_SECONDS (60) each: engine, surfaces, masks (libFuzzer, needs clang), contours, YAML
	@tests/fuzz/run.sh $(FUZZ_SECONDS) $(CORES)

test-python: build
	OMP_NUM_THREADS=1 $(PYTHON) -m pytest -q -n $(CORES) --dist loadscope --durations=15 -m "not slow and not long" \
	  --junitxml=results/tests/python.xml

.PHONY: test-slow
test-slow: sanitize build ## sanitizers, and the Python tests of five seconds or more; before a change is handed in
	OMP_NUM_THREADS=1 $(PYTHON) -m pytest -q -n $(CORES) --dist loadscope --durations=15 -m slow \
	  --junitxml=results/tests/python_slow.xml

.PHONY: test-long
test-long: build ## the longest verification runs; once a day, and before a release
	OMP_NUM_THREADS=1 $(PYTHON) -m pytest -q -n $(CORES) --dist loadscope --durations=15 -m long \
	  --junitxml=results/tests/python_long.xml

.PHONY: coverage
coverage: setup ## which lines the tests run, into README.md; TESTS=folder: of these tests in Python alone, printed
	@setup/install.sh packages-coverage.txt
	@tests/coverage/run.sh $(CORES) $(TESTS)

lint: setup ## check formatting and run the linters
	@setup/lint.sh

format: setup ## format C++ and Python sources
	git ls-files '*.cpp' '*.hpp' | xargs -r clang-format -i
	black -q .

docs: ## write the documentation as a site, build/site/index.html; installs Sphinx, MyST and furo if they are missing
	@setup/install.sh packages-docs.txt
	@sphinx-build -q -W --keep-going -c docs -b html . $(BUILD)/site
	@echo "documentation: $(BUILD)/site/index.html"

clean: ## remove what was built and computed
	rm -rf $(BUILD) build-sanitize build-fuzz build-coverage results .snakemake
