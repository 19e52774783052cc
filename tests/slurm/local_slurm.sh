#!/usr/bin/env bash
# A Slurm of two nodes on this machine for as long as a command runs, without accounting:
#   tests/slurm/local_slurm.sh snakemake --profile config/profiles/slurm --config cohort=quick
# Needs Debian's slurmctld, slurmd, slurm-client and munge. All files lie in a temporary folder; all daemons are stopped at the end.
# VCI_SLURM_FOLDER names the folder to the command: <node>.pid is the process of a node's slurmd.
set -euo pipefail
[ $# -gt 0 ] || { echo "usage: $0 COMMAND [ARGUMENT ...]" >&2; exit 2; }
PATH=$PATH:/usr/sbin
for program in munged slurmctld slurmd sbatch; do
  command -v "$program" >/dev/null ||
    { echo "$program is missing: apt-get install slurmctld slurmd slurm-client munge" >&2; exit 2; }
done

folder=$(mktemp -d /tmp/slurm.XXXXXX)
chmod 755 "$folder"
export SLURM_CONF=$folder/slurm.conf VCI_SLURM_FOLDER=$folder
user=$(id -un)
nodes=(node1 node2)
daemons=()

start() { # name, command: runs in the foreground of a job of its own, whose process is noted
  local name=$1
  shift
  setsid "$@" >"$folder/$name.out" 2>&1 &
  echo $! >"$folder/$name.pid"
  daemons+=($!)
}

stop() {
  trap '' INT TERM
  scancel --quiet --user "$user" 2>/dev/null || true
  for _ in $(seq 20); do
    [ -n "$(timeout 5 squeue --noheader 2>/dev/null)" ] || break
    sleep 0.5
  done
  kill "${daemons[@]}" 2>/dev/null || true
  wait "${daemons[@]}" 2>/dev/null || true
  # A slurmd that was killed leaves its steps and their jobs, whose environment names this folder.
  for process in /proc/[0-9]*; do
    if [ "${process#/proc/}" -ne $$ ] && grep -qzs "^SLURM_CONF=$SLURM_CONF\$" "$process/environ"; then
      kill -KILL "${process#/proc/}" 2>/dev/null || true
    fi
  done
  rm -rf "$folder"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

head -c 1024 /dev/urandom >"$folder/munge.key"
chmod 400 "$folder/munge.key"
start munged munged --foreground --key-file="$folder/munge.key" --socket="$folder/munge.socket" \
  --pid-file="$folder/munge.pid" --log-file="$folder/munge.log" --seed-file="$folder/munge.seed"

# Ports that are free now.
mapfile -t ports < <(/usr/bin/python3 - <<'PYTHON'
import socket

sockets = [socket.socket() for _ in range(3)]
for one in sockets:
    one.bind(("127.0.0.1", 0))
    print(one.getsockname()[1])
PYTHON
)
memory=$(awk '/^MemAvailable/ {print int($2 / 1024 / 2)}' /proc/meminfo)
cat >"$SLURM_CONF" <<CONF
ClusterName=local
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CryptoType=crypto/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool-%n
SlurmctldPidFile=$folder/slurmctld.daemon
SlurmdPidFile=$folder/slurmd-%n.daemon
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=5
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
SlurmdParameters=config_overrides
KillWait=5
MinJobAge=300
SchedulerParameters=sched_interval=2,bf_interval=5
NodeName=${nodes[0]} NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=1 RealMemory=$memory
NodeName=${nodes[1]} NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=1 RealMemory=$memory
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
echo "CgroupPlugin=cgroup/v1" >"$folder/cgroup.conf"
mkdir "$folder/state" "${nodes[@]/#/$folder/spool-}"

for _ in $(seq 50); do [ -S "$folder/munge.socket" ] && break; sleep 0.1; done
start slurmctld slurmctld -D -i
for node in "${nodes[@]}"; do start "$node" slurmd -D -N "$node"; done
for _ in $(seq 60); do
  [ "$(timeout 5 sinfo --noheader --Node --states=idle 2>/dev/null | wc -l)" -eq ${#nodes[@]} ] && break
  sleep 0.5
done
if [ "$(sinfo --noheader --Node --states=idle | wc -l)" -ne ${#nodes[@]} ]; then
  tail -n 20 "$folder"/*.out "$folder"/*.log >&2
  echo "the local Slurm did not come up" >&2
  exit 3
fi

status=0
"$@" || status=$?
exit "$status"
