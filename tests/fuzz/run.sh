#!/usr/bin/env bash
# Fuzzes each reader for SECONDS, JOBS readers at a time: run.sh SECONDS JOBS. Each format of a surface or mask is a reader.
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
readers=(scene lumen centreline surface.{stl,vtp,ply,obj,nii,nrrd,mha} python.{contours,case,study,device})
failed=0
printf '%s\n' "${readers[@]}" | xargs -P "$jobs" -I{} tests/fuzz/run_reader.sh {} "$seconds" || failed=1
[ "$seconds" -lt 600 ] || /usr/bin/python3 tests/fuzz/page.py --logs build-fuzz --seconds "$seconds" --out docs/fuzzing.md
exit $failed
