#!/usr/bin/env bash
# Fuzzes one reader: run_reader.sh READER SECONDS. READER is scene, lumen or centreline of the engine, surface.SUFFIX of the
# anatomy (libFuzzer, in C++), or python.NAME (seeded mutants). The log is build-fuzz/READER.log.
set -euo pipefail
reader=$1 seconds=$2
log=build-fuzz/$reader.log
echo "fuzzing $reader for $seconds s; log: $log"
report_fault() {
  echo "$reader: a fault, kept in build-fuzz/found: $(grep -m1 -E 'ERROR|SUMMARY|Error' "$log" || true)" >&2
  exit 1
}
if [[ $reader == python.* ]]; then
  PYTHONPATH=. /usr/bin/python3 tests/fuzz/python_readers.py --seconds "$seconds" --readers "${reader#python.}" \
    --out build-fuzz/found >"$log" 2>&1 || report_fault
  tail -n 1 "$log"
  exit 0
fi
kind=${reader%%.*} part=vci
if [ "$kind" = surface ]; then
  part=anatomy
  export VCI_FUZZ_SUFFIX=.${reader#*.}
fi
export LSAN_OPTIONS=suppressions=$PWD/tests/fuzz/leaks.txt:print_suppressions=0
mkdir -p "build-fuzz/corpus/$reader" # goes on from what earlier runs reached
words=()
[ ! -f "build-fuzz/seeds/$kind.dict" ] || words=(-dict="build-fuzz/seeds/$kind.dict")
"build-fuzz/${part}_fuzz_$kind" -max_total_time="$seconds" -timeout=25 -report_slow_units=5 -print_final_stats=1 \
  "${words[@]}" -artifact_prefix="build-fuzz/found/$reader-" \
  "build-fuzz/corpus/$reader" "build-fuzz/seeds/$reader" 2>"$log" || report_fault
echo "$reader: $(grep -oE '(number_of_executed_units|slowest_unit_time_sec|peak_rss_mb): *[0-9]+' "$log" | tr -s ' ' | paste -sd, -)"
