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
# They end by themselves within a second or two.
for file in "$folder"/qmaster/qmaster.pid "$folder"/execd/*/execd.pid; do
    [ -e "$file" ] || continue
    pid=$(cat "$file")
    for _ in $(seq 50); do [ -e "/proc/$pid/exe" ] && sleep 0.2 || break; done
    kill "$pid" 2>/dev/null
done
exit 0
