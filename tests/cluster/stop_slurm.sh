#!/usr/bin/env bash
# Ends the Slurm that start_slurm.sh started in a folder, with its jobs.
#
#     stop_slurm.sh FOLDER
set -uo pipefail
folder=$(realpath "${1:?the folder of start_slurm.sh}")
export SLURM_CONF=$folder/slurm.conf

squeue --noheader --format=%i 2>/dev/null | xargs --no-run-if-empty scancel
for _ in $(seq 50); do
    [ -z "$(squeue --noheader 2>/dev/null)" ] && break
    sleep 0.2
done
scontrol shutdown 2>/dev/null
pids=("$folder"/{slurmctld.,node1.,node2.,munge/}pid)

# Each removes its own when it has ended.
wait_for() {
    for _ in $(seq 50); do
        for pid in "$@"; do [ -e "$pid" ] && sleep 0.2 && continue 2; done
        return
    done
}
wait_for "${pids[@]:0:3}"
for pid in "${pids[@]}"; do
    [ -e "$pid" ] && kill "$(cat "$pid")" 2>/dev/null
done
wait_for "${pids[@]}"
exit 0
