#!/bin/sh
# A Slurm cluster of virtual nodes on this machine, for tests: no accounts, no cgroups, nothing outside of DIR.
#   cluster.sh start DIR NODES     prints nothing and returns when all nodes are idle
#   cluster.sh kill-node DIR N     kills slurmd N and what it runs, as if its power failed
#   cluster.sh stop DIR
# Programs find it by SLURM_CONF=DIR/slurm.conf. Needs to be root: slurmd starts jobs as their users.
set -eu
action=$1 dir=$2
export SLURM_CONF="$dir/slurm.conf"

free_port() {  # the kernel knows which are free; the first of a row of NODES + 1
  python3 - "$1" <<'PY'
import random, socket, sys
count = int(sys.argv[1])
while True:
    first = random.randrange(20000, 60000)
    try:
        held = []
        for port in range(first, first + count):
            s = socket.socket(); s.bind(("", port)); held.append(s)
    except OSError:
        continue
    print(first); break
PY
}

case $action in
start)
  nodes=$3
  mkdir -p "$dir/state"
  port=$(free_port $((nodes + 1)))
  cat > "$SLURM_CONF" <<CONF
ClusterName=plumbline
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=$port
SlurmUser=root
AuthType=auth/none
CredType=cred/none
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool.%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.%n.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.%n.log
SlurmdTimeout=8
ReturnToService=2
KillWait=2
UnkillableStepTimeout=30
SchedulerParameters=sched_interval=1,batch_sched_delay=0,sched_min_interval=0
NodeName=n[1-$nodes] NodeAddr=127.0.0.1 NodeHostName=$(hostname -s) Port=[$((port + 1))-$((port + nodes))] CPUs=1 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
  slurmctld -c
  for n in $(seq "$nodes"); do
    mkdir -p "$dir/spool.n$n"
    slurmd -N "n$n"
  done
  for _ in $(seq 300); do
    [ "$(sinfo -h -o '%D %t' 2>/dev/null)" = "$nodes idle" ] && exit 0
    sleep 0.2
  done
  echo "the nodes did not come up:" >&2
  sinfo >&2 || true
  tail -5 "$dir"/*.log >&2
  exit 1
  ;;
kill-node)
  kill -9 "$(cat "$dir/slurmd.n$3.pid")"
  # What it was running has this cluster and its node in its environment; the keeper of a job (slurmstepd) has not, but
  # it is their parent.
  python3 - "$SLURM_CONF" "n$3" <<'PY'
import os, signal, sys
conf, node = sys.argv[1:]
doomed = set()
for process in filter(str.isdigit, os.listdir("/proc")):
    try:
        environment = open(f"/proc/{process}/environ", "rb").read().split(b"\0")
        parent = int(open(f"/proc/{process}/stat").read().rsplit(")", 1)[1].split()[1])
        if f"SLURM_CONF={conf}".encode() in environment and f"SLURMD_NODENAME={node}".encode() in environment:
            doomed.add(int(process))
            if "slurmstepd" in open(f"/proc/{parent}/comm").read():
                doomed.add(parent)
    except OSError:
        pass  # it ended meanwhile, or is none of ours
for process in sorted(doomed):
    try:
        os.kill(process, signal.SIGKILL)
    except OSError:
        pass
PY
  exit 0
  ;;
stop)
  for file in "$dir"/slurmd.*.pid "$dir/slurmctld.pid"; do
    [ -s "$file" ] && kill "$(cat "$file")" 2>/dev/null || true
  done
  exit 0
  ;;
esac
