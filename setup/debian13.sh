#!/usr/bin/env bash
# Runs the sources' last commit on Debian 13 (trixie), in a root folder that it makes on another Debian.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
usage() {
  cat <<'TEXT'
usage: setup/debian13.sh [--root FOLDER] [COMMAND]

Makes a Debian 13 in FOLDER (build-debian13) unless it is there, installs setup/packages.txt in it, copies the last commit to
/vci there, and runs COMMAND, a shell's line, in it. Without COMMAND: the quick cohort, and the comparison with the manifest that
ships, whose page is left as FOLDER/vci/results/debian13.md.

Needs root, mmdebstrap, 7 GB, and the archive that this system's apt takes its packages from. Nothing outside FOLDER is written,
and mounts end with the command. CORES (all) and OMP_NUM_THREADS (1) pass into it, and so do the certificates in the file that
NODE_EXTRA_CA_CERTS names, for npm behind a proxy. Exit code 77 where it cannot run at all.
TEXT
}

skip() { # reason, remedy
  printf 'skipped: %s\n  remedy: %s\n' "$1" "$2" >&2
  exit 77
}

root=$here/build-debian13
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage; exit 0 ;;
    --root) [ $# -gt 1 ] || { usage >&2; exit 2; }; root=$(realpath -m "$2"); shift 2 ;;
    --root=*) root=$(realpath -m "${1#--root=}"); shift ;;
    -*) usage >&2; exit 2 ;;
    *) break ;;
  esac
done
default='make study COHORT=quick CORES=$CORES &&
  /usr/bin/python3 -m workflow agreement --manifest config/manifests/quick.json --out results/debian13.md'
command=${*:-$default}

[ "$(id -u)" -eq 0 ] || skip "making and entering a root folder needs root" "run it as root"
command -v mmdebstrap >/dev/null || skip "mmdebstrap is missing" "apt-get install mmdebstrap"
unshare --mount true 2>/dev/null || skip "this system allows no mounts" "run it outside of the container"

if [ ! -d "$root" ]; then
  mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Label: Debian' | head -n 1)
  [ -n "$mirror" ] || skip "apt knows no Debian archive" "run apt-get update"
  rm -rf "$root.partial"
  mmdebstrap --mode=root --variant=apt --include=ca-certificates trixie "$root.partial" "$mirror"
  mv "$root.partial" "$root"
fi
git init -q "$root/vci"
git -C "$root/vci" fetch -q --depth 1 "file://$here" HEAD
git -C "$root/vci" reset -q --hard FETCH_HEAD

extra=
if [ -f "${NODE_EXTRA_CA_CERTS:-}" ]; then
  extra=/etc/ssl/extra-ca.crt
  cp "$NODE_EXTRA_CA_CERTS" "$root$extra"
fi

# The command gets its own mount namespace. It needs /dev for MPI's shared memory. /proc shows its own processes alone.
export ROOT="$root" COMMAND="$command" EXTRA="$extra"
export CORES=${CORES:-$(nproc)} OMP_NUM_THREADS=${OMP_NUM_THREADS:-1}
exec unshare --mount --pid --fork --kill-child bash -euc '
  mount --rbind /dev "$ROOT/dev"
  mount -t proc proc "$ROOT/proc"
  mount -t sysfs sysfs "$ROOT/sys"
  exec chroot "$ROOT" /usr/bin/env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    CORES="$CORES" OMP_NUM_THREADS="$OMP_NUM_THREADS" ${EXTRA:+NODE_EXTRA_CA_CERTS="$EXTRA"} bash -euc "cd /vci && bash setup/install.sh && $COMMAND"'
