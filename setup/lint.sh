#!/usr/bin/env bash
# Checks format and code of everything under version control. Shows all complaints, then fails if there was one.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failed=0
check() { # name, command...
  local name=$1 output
  shift
  if output=$("$@" 2>&1); then
    echo "lint: $name: clean"
  else
    printf 'lint: %s:\n%s\n' "$name" "$output"
    failed=1
  fi
}

# One complaint is ignored: rules name no conda environment, since they run on the packages of setup/packages.txt.
lint_workflow() {
  local complaints
  complaints=$(/usr/bin/snakemake --lint 2>&1) && return 0
  grep -q '^Lints for' <<<"$complaints" || { echo "$complaints"; return 1; }
  awk '/^Lints for/ {of = $0}
    /^    \* / && !/^    \* Specify a conda environment or container/ {print of; print; bad = 1}
    END {exit bad}' <<<"$complaints"
}

mapfile -t python < <(git ls-files '*.py')
mapfile -t cpp < <(git ls-files '*.cpp' '*.hpp')
mapfile -t sources < <(git ls-files '*.cpp' | grep -v '^tests/')
mapfile -t shell < <(git ls-files '*.sh' .ci/run)
check black black --check --quiet --diff "${python[@]}"
check flake8 /usr/bin/python3 -m flake8 "${python[@]}"
if [ ${#cpp[@]} -gt 0 ]; then
  check clang-format clang-format --dry-run -Werror "${cpp[@]}"
  check cppcheck cppcheck --quiet --std=c++20 --language=c++ --enable=warning,performance,portability --inline-suppr \
    --suppressions-list=setup/cppcheck-suppressions.txt --error-exitcode=1 -j "$(nproc)" -I . -I anatomy/src "${sources[@]}"
fi
for script in "${shell[@]}"; do
  check "bash -n $script" bash -n "$script"
done
check "snakemake --lint" lint_workflow
check configuration /usr/bin/python3 -m workflow validate
exit $failed
