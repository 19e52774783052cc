#!/usr/bin/env bash
# Installs the missing Debian packages of setup/packages.txt, or of another list beside it. Works as root and with sudo.
# If no package is missing, it takes well under a second.
# Usage: install.sh [LIST]
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
list=${1:-packages.txt}

fail() { # what, remedy
  printf 'setup failed: %s\n  remedy: %s\n' "$1" "$2" >&2
  exit 1
}

command -v dpkg-query >/dev/null ||
  fail "this is not a Debian system" "use Debian 12 or 13, or install what setup/$list lists by other means and run 'make build'"

mapfile -t wanted < <(sed 's/#.*//' "$here/$list" | tr -s '[:space:]' '\n' | sed '/^$/d')
installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${wanted[@]}" 2>/dev/null | awk '$1 == "installed" {print $2}' || true)
missing=()
for package in "${wanted[@]}"; do
  grep -qx "$package" <<<"$installed" || missing+=("$package")
done

if [ ${#missing[@]} -gt 0 ]; then
  echo "setup: installing ${#missing[@]} missing Debian packages: ${missing[*]}"
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      fail "packages are missing, and this is neither root nor is there sudo" "as root: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
  "${apt[@]}" update -qq ||
    fail "the package lists cannot be fetched" "check the network and the sources in /etc/apt, then run make again"
  unknown=()
  for package in "${missing[@]}"; do
    [ -n "$(apt-cache policy "$package" | awk '/Candidate:/ && $2 != "(none)" {print $2}')" ] || unknown+=("$package")
  done
  [ ${#unknown[@]} -eq 0 ] ||
    fail "not in this system's package lists: ${unknown[*]}" "use Debian 12 or 13 with its main archive in /etc/apt, then run make again"
  "${apt[@]}" install -y -qq --no-install-recommends "${missing[@]}" ||
    fail "apt-get could not install the packages" "read its message above; often 'apt-get -f install' or free disk space helps"
  echo "setup: done"
fi

blas=$(readlink -f "/usr/lib/$(dpkg --print-architecture | sed 's/amd64/x86_64/;s/arm64/aarch64/')-linux-gnu/libblas.so.3" || true)
case "$blas" in
  *openblas*) ;;
  *) echo "setup: note: the system's BLAS is $blas, chosen by hand; OpenBLAS makes the flow solver about twice as fast: update-alternatives --config libblas.so.3-$(uname -m)-linux-gnu" >&2 ;;
esac
