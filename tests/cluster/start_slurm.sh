#!/usr/bin/env bash
# Starts a real Slurm of one node on this machine, as root and without systemd, in a second or two.
#
#     start_slurm.sh FOLDER PORT
#
# It keeps everything in FOLDER, its own munge too, and listens at PORT and PORT + 1, so that several
# can run at a time. To use it: export SLURM_CONF=FOLDER/slurm.conf. To end it: stop_slurm.sh FOLDER.
set -euo pipefail
folder=$(realpath "${1:?a folder for its state}")
port=${2:?a port, of two that are free}
host=$(hostname -s)

mkdir -p "$folder"/{state,spool,munge}
chmod 755 "$folder" "$folder/munge"
dd if=/dev/urandom of="$folder/munge/key" bs=128 count=1 status=none
chmod 600 "$folder/munge/key"
munged --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" \
    --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" --seed-file="$folder/munge/seed"

# More processors than the machine may have: what is tested is Slurm, not speed.
cat >"$folder/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=2,sched_min_interval=0
ReturnToService=1
MpiDefault=none
KillWait=2
CompleteWait=0
NodeName=node NodeHostname=$host NodeAddr=127.0.0.1 CPUs=8 RealMemory=1000 State=UNKNOWN
PartitionName=short Nodes=ALL Default=YES MaxTime=INFINITE State=UP
PartitionName=closed Nodes=ALL MaxTime=1 State=UP
CONF
export SLURM_CONF=$folder/slurm.conf
slurmctld
slurmd -N node
for _ in $(seq 100); do
    if sinfo --noheader --format=%T 2>/dev/null | grep -qx idle; then exit 0; fi
    sleep 0.2
done
echo "Slurm did not start; its logs are in $folder" >&2
tail -n 20 "$folder"/*.log >&2
exit 1
