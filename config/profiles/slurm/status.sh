#!/usr/bin/env bash
# status.sh JOB prints success, failed or running, the words that Snakemake expects. It needs no accounting: Slurm's
# controller keeps a job's state for MinJobAge (default 300 s) after its end. Later the script asks sacct, if it can.
set -uo pipefail
job=${1:?usage: status.sh JOB}; job=${job%%;*} # sbatch --parsable appends the cluster's name on a federation

if answer=$(scontrol show job --oneliner "$job" 2>&1); then
  state=$(grep -om1 'JobState=[A-Z_]*' <<<"$answer" | cut -d= -f2)
elif grep -q 'Invalid job id' <<<"$answer"; then
  state=$(sacct --noheader --parsable2 --allocations --format=State --jobs="$job" 2>/dev/null | head -n1 | cut -d' ' -f1)
  [ -n "$state" ] || { echo "Slurm no longer knows job $job and keeps no accounts; it is run again" >&2; state=UNKNOWN; }
else
  state=RUNNING # the controller does not answer now, which says nothing about the job
fi

case $state in
  COMPLETED) echo success ;;
  BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | PREEMPTED | REVOKED | TIMEOUT | UNKNOWN) echo failed ;;
  *) echo running ;;
esac
