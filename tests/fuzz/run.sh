#!/usr/bin/env bash
# Fuzzes each reader in C++ with libFuzzer, and the readers in Python with mutants: run.sh SECONDS JOBS.
# What it finds stays in build-fuzz/found. A run of ten minutes for each reader writes docs/fuzzing.md.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
seconds=$1 jobs=$2
targets=(vci_fuzz_scene vci_fuzz_lumen vci_fuzz_centreline anatomy_fuzz_surface)
if ! clang++ -fsanitize=fuzzer,address,undefined -x c++ -o /dev/null - 2>/dev/null \
  <<<'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'; then
  echo "make fuzz: clang++ with libFuzzer is missing" >&2
  echo "  remedy: apt-get install clang libclang-rt-14-dev (no other target needs them)" >&2
  exit 1
fi
[ -f build-fuzz/build.ninja ] || CC=clang CXX=clang++ cmake -S . -B build-fuzz -G Ninja \
  -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" -DVCI_FUZZ=ON -DVCI_TESTS=OFF
ninja -C build-fuzz -j "$jobs" "${targets[@]}"
for corpus in fuzz_corpus surface_corpus; do
  PYTHONPATH=. /usr/bin/python3 "tests/fuzz/$corpus.py" --out build-fuzz/seeds
done
mkdir -p build-fuzz/found
rm -f build-fuzz/*.log
export LSAN_OPTIONS=suppressions=$PWD/tests/fuzz/leaks.txt:print_suppressions=0
failed=0
for target in "${targets[@]}"; do
  reader=${target#*_fuzz_}
  mkdir -p "build-fuzz/corpus/$reader" # goes on from what earlier runs reached
  words=()
  [ ! -f "build-fuzz/seeds/$reader.dict" ] || words=(-dict="build-fuzz/seeds/$reader.dict")
  echo "fuzzing the reader of a $reader for $seconds s; log: build-fuzz/$reader.log"
  if ! "build-fuzz/$target" -max_total_time="$seconds" -timeout=25 -report_slow_units=5 -print_final_stats=1 \
    "${words[@]}" -artifact_prefix="build-fuzz/found/$reader-" \
    "build-fuzz/corpus/$reader" "build-fuzz/seeds/$reader" 2>"build-fuzz/$reader.log"; then
    echo "$reader: a fault, kept in build-fuzz/found: $(grep -m1 -E 'ERROR|SUMMARY' "build-fuzz/$reader.log" || true)" >&2
    failed=1
  fi
  grep -E '(number_of_executed_units|slowest_unit_time_sec|peak_rss_mb)' "build-fuzz/$reader.log" || true
  grep -oE 'cov: [0-9]+ ft: [0-9]+' "build-fuzz/$reader.log" | tail -1 || true # edges, features
done
PYTHONPATH=. /usr/bin/python3 tests/fuzz/python_readers.py --seconds "$seconds" --out build-fuzz/found |
  tee build-fuzz/python.log || failed=1
[ "$seconds" -lt 600 ] || /usr/bin/python3 tests/fuzz/page.py --logs build-fuzz --seconds "$seconds" --out docs/fuzzing.md
exit $failed
