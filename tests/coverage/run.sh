#!/usr/bin/env bash
# Counts the lines of C++ and Python that the tests of `make test` and `make test-slow` run: run.sh JOBS [TESTS ...]
# Without TESTS all tests run, and the figures go into README.md. Named Python tests run alone, and the figures are only
# printed; C++ then counts as far as it is built.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
jobs=$1
shift
folder=$PWD/build-coverage
mkdir -p "$folder"
find "$folder" -name '*.gcda' -delete
rm -f "$folder"/python* "$folder"/*.json
status=0
[ -f "$folder/build.ninja" ] || cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" -DVCI_COVERAGE=ON
ninja -C "$folder" -j "$jobs" flow_factors # without which no flow runs
if [ $# -eq 0 ]; then
  ninja -C "$folder" -j "$jobs"
  ctest --test-dir "$folder" --output-on-failure -j "$jobs" --quiet || status=$?
fi

export VCI_ROOT=$PWD VCI_BUILD_DIR=$folder OMP_NUM_THREADS=1
export COVERAGE_FILE=$folder/python COVERAGE_PROCESS_START=$PWD/tests/coverage/coveragerc
PYTHONPATH=$PWD/tests/coverage${PYTHONPATH:+:$PYTHONPATH} \
  /usr/bin/python3 -m pytest -q -n "$jobs" --dist loadscope -m "not long" "${@:-tests}" || status=$?
python3-coverage combine -q --rcfile="$COVERAGE_PROCESS_START"
python3-coverage json -q --rcfile="$COVERAGE_PROCESS_START" -o "$folder/python.json"
if [ -n "$(find "$folder" -name '*.gcda' -print -quit)" ]; then
  gcovr --root . --filter 'anatomy/' --filter 'common/' --filter 'flow/' --filter 'vci/' --json-summary "$folder/cpp.json" "$folder"
fi
[ "$status" -eq 0 ] || { echo "coverage: tests failed, README.md stays as it is" >&2; exit "$status"; }
/usr/bin/python3 tests/coverage/figure.py "$folder" $([ $# -gt 0 ] || echo --readme README.md)
