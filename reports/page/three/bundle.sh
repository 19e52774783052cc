#!/usr/bin/env bash
# three.js and its trackball controls as one classic script: bundle.sh OUT.js. README.md says why and how.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=$(realpath -m "$1")
folder=$(dirname "$out")/three
command -v npm >/dev/null || "$here/../../../setup/install.sh" packages-page.txt
mkdir -p "$folder"
cp "$here"/{package.json,package-lock.json,entry.js} "$folder"
cd "$folder"
if ! npm ci --no-audit --no-fund --loglevel=error; then
  printf 'error: three.js cannot be fetched\n  where:  %s\n  value:  npm ci failed, see above\n  remedy: check the network and the npm registry, then run make build again\n' "$here/package-lock.json" >&2
  exit 1
fi
npx --no-install esbuild entry.js --bundle --minify --format=iife --global-name=THREE --log-level=warning --outfile="$out.part"
mv "$out.part" "$out"
