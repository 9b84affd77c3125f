#!/usr/bin/env bash
# one_node_slurm.sh COMMAND...
# Runs a command with a SLURM cluster that consists of this machine alone, and ends the cluster afterwards:
# to try the workflow's profile `slurm` where there is no cluster. Needs the packages slurm-wlm and munge,
# and root. The cluster is private to a temporary folder; SLURM_CONF names its configuration.
set -euo pipefail

fail() {
  printf 'one_node_slurm.sh: %s\n' "$*" >&2
  exit 1
}

(($# > 0)) || { sed -n '2,5s/^# //p' "${BASH_SOURCE[0]}"; exit 2; }
((EUID == 0)) || fail "has to be root, as slurmd has"
for program in munged slurmctld slurmd sbatch; do
  command -v "$program" >/dev/null || fail "$program is missing; install slurm-wlm and munge"
done

folder=$(mktemp -d /tmp/one_node_slurm.XXXXXX)
pids=()
finish() {
  # The last one started ends first.
  local i
  for ((i = ${#pids[@]} - 1; i >= 0; i--)); do
    kill "${pids[i]}" 2>/dev/null || true
    wait "${pids[i]}" 2>/dev/null || true
  done
  rm -rf "$folder"
}
trap finish EXIT

mkdir "$folder"/{state,spool,munge}
chmod 755 "$folder"
chmod 700 "$folder/munge"
head -c 1024 /dev/urandom >"$folder/munge/key"
chmod 400 "$folder/munge/key"
# Its folders have to be safe from others, which /tmp is not in its eyes.
munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge.socket" \
  --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" &>"$folder/munged.log" &
pids+=($!)

host=$(hostname -s)
free_port() {
  /usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])'
}
cat >"$folder/slurm.conf" <<CONF
ClusterName=one_node
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MailProg=/bin/true
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=0
ReturnToService=2
SlurmdTimeout=60
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(awk '/MemTotal/ {print int($2 / 1024 * 0.9)}' /proc/meminfo)
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
slurmctld -D -i &>>"$folder/slurmctld.log" &
pids+=($!)
slurmd -D &>>"$folder/slurmd.log" &
pids+=($!)

for ((i = 0; ; i++)); do
  [[ $(sinfo --noheader --format=%t 2>/dev/null) == idle ]] && break
  ((i < 60)) || { tail -n 20 "$folder"/*.log >&2; fail "the node does not become idle"; }
  sleep 0.5
done
"$@"
