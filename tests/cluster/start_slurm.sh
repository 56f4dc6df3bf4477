#!/usr/bin/env bash
# Starts a real Slurm of two nodes on this machine, as root and without systemd, in a second or two.
#
#     start_slurm.sh FOLDER PORT
#
# It keeps everything in FOLDER, its own munge too, and listens at PORT to PORT + 2, so that several
# can run at a time. To use it: export SLURM_CONF=FOLDER/slurm.conf. To end it: stop_slurm.sh FOLDER.
set -euo pipefail
folder=$(realpath "${1:?a folder for its state}")
port=${2:?a port, the first of three that are free}
host=$(hostname -s)

mkdir -p "$folder"/{state,spool/node1,spool/node2,munge}
chmod 755 "$folder" "$folder/munge"
dd if=/dev/urandom of="$folder/munge/key" bs=128 count=1 status=none
chmod 600 "$folder/munge/key"
munged --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed"

# More processors than the machine may have: what is tested is Slurm, not speed. A job that is requeued
# waits until its credential has expired.
cat >"$folder/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket,cred_expire=5
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool/%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=2,sched_min_interval=0
ReturnToService=1
MpiDefault=none
KillWait=2
MinJobAge=3600
CompleteWait=0
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
NodeName=node1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=8 RealMemory=1000
NodeName=node2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=8 RealMemory=1000
PartitionName=short Nodes=ALL Default=YES MaxTime=INFINITE
PartitionName=closed Nodes=ALL MaxTime=1
PartitionName=urgent Nodes=ALL PriorityTier=10
CONF
export SLURM_CONF=$folder/slurm.conf
slurmctld
slurmd -N node1
slurmd -N node2
for _ in $(seq 100); do
    idle=$(sinfo --noheader --partition=short --states=idle --format=%D 2>/dev/null || true)
    if [ "${idle// /}" = 2 ]; then exit 0; fi
    sleep 0.2
done
echo "Slurm did not start; its logs are in $folder" >&2
tail -n 20 "$folder"/*.log >&2
exit 1
