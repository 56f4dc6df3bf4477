#!/usr/bin/env bash
# Ends the Grid Engine that start_gridengine.sh has started in FOLDER, with its jobs.
#
#     stop_gridengine.sh FOLDER
set -uo pipefail
folder=$(realpath "${1:?the folder of its state}")
set -a
# shellcheck disable=SC1091
. "$folder/environment"
set +a
qdel -f -u '*' >/dev/null 2>&1
qconf -ke all >/dev/null 2>&1
qconf -km >/dev/null 2>&1
for _ in $(seq 50); do
    pgrep -f "^sge_(qmaster|execd)" >/dev/null || break
    sleep 0.1
done
for pid in "$folder"/qmaster/qmaster.pid "$folder"/execd/*/execd.pid; do
    [ -e "$pid" ] && kill "$(cat "$pid")" 2>/dev/null
done
exit 0
