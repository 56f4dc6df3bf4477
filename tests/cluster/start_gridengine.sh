#!/usr/bin/env bash
# Starts a real Grid Engine of one node on this machine, as root and without systemd.
#
#     start_gridengine.sh FOLDER PORT
#
# It keeps everything in FOLDER and listens at PORT and PORT + 1. To use it: export the variables of
# FOLDER/environment. To end it: stop_gridengine.sh FOLDER.
set -euo pipefail
folder=$(realpath "${1:?a folder for its state}")
port=${2:?a port, the first of two that are free}
host=$(hostname)
cat >"$folder/environment" <<ENV
SGE_ROOT=$folder
SGE_CELL=default
SGE_QMASTER_PORT=$port
SGE_EXECD_PORT=$((port + 1))
ENV
set -a
# shellcheck disable=SC1091
. "$folder/environment"
set +a

mkdir -p "$folder"/{default/common,spooldb,qmaster,execd}
chmod 755 "$folder"
for part in util bin lib utilbin; do ln -s "/var/lib/gridengine/$part" "$folder/$part"; done
echo "$host" >"$folder/default/common/act_qmaster"
# Where this machine's address has another name first.
echo "$host localhost" >"$folder/default/common/host_aliases"
sed -e "s|^admin_user.*|admin_user none|" \
    -e "s|/var/spool/gridengine|$folder|" /usr/share/gridengine/default-bootstrap \
    >"$folder/default/common/bootstrap"
/usr/share/gridengine/scripts/init_cluster "$folder" default "$folder/spooldb" root
# Jobs of root, too; and the scheduler looks at the queue every second.
sed -e "s|^execd_spool_dir.*|execd_spool_dir $folder/execd|" -e "s|^min_[ug]id.*|# &|" \
    /usr/share/gridengine/default-configuration >"$folder/configuration"
printf "min_uid 0\nmin_gid 0\n" >>"$folder/configuration"
/usr/lib/gridengine/spooldefaults configuration "$folder/configuration"

sge_qmaster
for _ in $(seq 50); do qconf -sh >/dev/null 2>&1 && break; sleep 0.2; done
qconf -ah "$host" 2>/dev/null || true
qconf -as "$host"
qconf -ssconf | sed -e "s|^schedule_interval.*|schedule_interval 0:0:1|" >"$folder/scheduler"
qconf -Msconf "$folder/scheduler"
cat >"$folder/pe" <<PE
pe_name smp
slots 64
user_lists NONE
xuser_lists NONE
start_proc_args NONE
stop_proc_args NONE
allocation_rule \$pe_slots
control_slaves FALSE
job_is_first_task TRUE
urgency_slots min
accounting_summary FALSE
qsort_args NONE
PE
qconf -Ap "$folder/pe"
qconf -sq | sed -e "s|^qname.*|qname short|" -e "s|^hostlist.*|hostlist $host|" \
    -e "s|^slots.*|slots 8|" -e "s|^pe_list.*|pe_list smp|" -e "s|^shell .*|shell /bin/bash|" \
    -e "s|^load_thresholds.*|load_thresholds NONE|" >"$folder/queue"
qconf -Aq "$folder/queue"
sge_execd
for _ in $(seq 100); do
    qstat -f -q short 2>/dev/null | grep -q "short@.*BIP *0/0/8.* lx[^ ]* *$" && exit 0
    sleep 0.2
done
echo "Grid Engine did not start; its logs are in $folder" >&2
qstat -f >&2 || true
tail -n 20 "$folder"/qmaster/messages "$folder"/execd/*/messages >&2
exit 1
