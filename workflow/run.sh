#!/usr/bin/env bash
# run.sh LOG COMMAND...: runs the command with its output in LOG; if it fails, shows the log's end and keeps its exit code.
log=$1
shift
"$@" >"$log" 2>&1 && exit 0
status=$?
{
  printf '\n%s failed (exit code %s); the end of its log:\n' "$log" "$status"
  tail -n 30 "$log" | sed 's/^/  | /'
} >&2
exit "$status"
