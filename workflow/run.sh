#!/usr/bin/env bash
# run.sh LOG COMMAND...: runs the command with its output in LOG, whose first line is the command as a shell would take it;
# if it fails, shows the log's end, notes the exit code in LOG.failed (`workflow failed` reads it) and keeps it.
log=$1
shift
rm -f "$log.failed"
words=$(printf ' %q' "$@")
printf '$%s\n' "$words" >"$log" && # at once, so that a reader never sees half a line
"$@" >>"$log" 2>&1 && exit 0
status=$?
echo "$status" >"$log.failed"
{
  printf '\n%s failed (exit code %s); the end of its log:\n' "$log" "$status"
  tail -n 30 "$log" | sed 's/^/  | /'
} >&2
exit "$status"
