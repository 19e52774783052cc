#!/usr/bin/env bash
# A Slurm of two nodes on this machine for as long as a command runs:
#   tests/slurm/local_slurm.sh snakemake --profile config/profiles/slurm --config cohort=quick
# Needs Debian's slurmctld, slurmd, slurm-client and munge. All files lie in a temporary folder. All daemons are stopped
# at the end.
# VCI_SLURM_ACCOUNT=name keeps accounts under that name and needs Debian's slurmdbd and mariadb-server. Without it there
# is no accounting.
# VCI_SLURM_FORGETS: seconds after which the controller forgets a job that ended (300).
# The command finds the folder in VCI_SLURM_FOLDER: <node>.pid has the process id of a node's slurmd.
set -euo pipefail
[ $# -gt 0 ] || { echo "usage: $0 COMMAND [ARGUMENT ...]" >&2; exit 2; }
PATH=$PATH:/usr/sbin
for program in munged slurmctld slurmd sbatch; do
  command -v "$program" >/dev/null ||
    { echo "$program is missing: apt-get install slurmctld slurmd slurm-client munge" >&2; exit 2; }
done

folder=$(mktemp -d --tmpdir slurm.XXXXXX)
chmod 755 "$folder"
export SLURM_CONF=$folder/slurm.conf VCI_SLURM_FOLDER=$folder
user=$(id -un)
nodes=(node1 node2)
daemons=()

start() { # NAME COMMAND ...: runs the command in a session of its own and notes its process id
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
  # A killed slurmd leaves the processes of its jobs behind. Their environment names this folder.
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

sockets = [socket.socket() for _ in range(5)]
for one in sockets:
    one.bind(("127.0.0.1", 0))
    print(one.getsockname()[1])
PYTHON
)
memory=$(awk '/^MemAvailable/ {print int($2 / 1024 / 2)}' /proc/meminfo)
accounting=AccountingStorageType=accounting_storage/none
if [ -n "${VCI_SLURM_ACCOUNT:-}" ]; then
  # Jobs of a user without an account are refused, as on a cluster that bills.
  accounting="AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=127.0.0.1
AccountingStoragePort=${ports[3]}
AccountingStoragePass=$folder/munge.socket
AccountingStorageEnforce=associations"
fi
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
$accounting
MpiDefault=none
ReturnToService=2
SlurmdTimeout=10
SlurmdParameters=config_overrides
KillWait=5
MinJobAge=${VCI_SLURM_FORGETS:-300}
SchedulerParameters=sched_interval=2,bf_interval=5
NodeName=${nodes[0]} NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=1 RealMemory=$memory
NodeName=${nodes[1]} NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=1 RealMemory=$memory
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
echo "CgroupPlugin=cgroup/v1" >"$folder/cgroup.conf"
mkdir "$folder/state" "${nodes[@]/#/$folder/spool-}"

for _ in $(seq 50); do [ -S "$folder/munge.socket" ] && break; sleep 0.1; done
if [ -n "${VCI_SLURM_ACCOUNT:-}" ]; then
  mariadb-install-db --no-defaults --user="$user" --datadir="$folder/database" --auth-root-authentication-method=socket \
    --skip-test-db >"$folder/mariadb-install.out" 2>&1
  start mariadb mariadbd --no-defaults --user="$user" --datadir="$folder/database" --socket="$folder/mariadb.socket" \
    --bind-address=127.0.0.1 --port="${ports[4]}" --pid-file="$folder/mariadb.daemon"
  for _ in $(seq 100); do [ -S "$folder/mariadb.socket" ] && break; sleep 0.1; done
  password=$(head -c 16 /dev/urandom | od -An -tx1 | tr -d ' \n')
  mariadb --no-defaults --user="$user" --socket="$folder/mariadb.socket" \
    --execute="create database slurm_acct_db; create user slurm@'127.0.0.1' identified by '$password'; create user slurm@localhost identified by '$password'; grant all on slurm_acct_db.* to slurm@'127.0.0.1'; grant all on slurm_acct_db.* to slurm@localhost"
  (
    umask 077
    cat >"$folder/slurmdbd.conf" <<CONF
DbdHost=localhost
DbdAddr=127.0.0.1
DbdPort=${ports[3]}
SlurmUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
PidFile=$folder/slurmdbd.daemon
LogFile=$folder/slurmdbd.log
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort=${ports[4]}
StorageUser=slurm
StoragePass=$password
StorageLoc=slurm_acct_db
CONF
  )
  start slurmdbd slurmdbd -D
  # slurmdbd must know the cluster before the controller starts.
  for _ in $(seq 60); do timeout 5 sacctmgr --immediate add cluster local >"$folder/sacctmgr.out" 2>&1 && break; sleep 0.5; done
  sacctmgr --immediate add account "$VCI_SLURM_ACCOUNT" cluster=local >>"$folder/sacctmgr.out"
  sacctmgr --immediate add user "$user" account="$VCI_SLURM_ACCOUNT" cluster=local >>"$folder/sacctmgr.out"
fi
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
