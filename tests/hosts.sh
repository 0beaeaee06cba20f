#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Hosts of a cluster, imitated on one machine: a network namespace each with a name and an address of its own, joined by a
# bridge, with so much bandwidth each way. The build by 1, 2, 4 and 8 ranks, one a host, has to give the bytes of the build
# without MPI; what went over the network is counted at the hosts' own interfaces. Then a rank is killed amid its work: the
# job has to end with mpirun's exit code, nothing may look finished, and another number of ranks takes up what was left.
#
# By hand, as root (doc/guide/large-volumes.md has what it printed): bash tests/hosts.sh [SIZE [RATE ...]], such as 256 10gbit 100mbit.
# A file that all hosts see stands for their shared disk, which is not slowed down.
. "$(dirname "$0")/lib.sh"
size=${1:-128}
shift $(($# > 0))
rates=("$@")
[ ${#rates[@]} -gt 0 ] || rates=(10gbit 100mbit)
lacks() { skip hosts_in_namespaces "$1"; exit 0; }
[ "$(id -u)" = 0 ] || lacks "network namespaces need root"
for program in ip tc mpirun unshare; do command -v $program >/dev/null || lacks "no $program (iproute2, openmpi-bin, util-linux)"; done
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_base_warn_component_unused=0 OMP_NUM_THREADS=1
prefix=iso$$h
hub=${prefix}ub
ip netns add "$hub" 2>/dev/null || lacks "this system makes no network namespaces"
remove() {
    for host in $(ip netns list | awk -v p="$prefix" 'index($1, p) == 1 { print $1 }'); do ip netns del "$host"; done
    rm -rf "$dir" "$HOME"
}
trap remove EXIT
ip -n "$hub" link add bridge type bridge && ip -n "$hub" link set bridge up

# Both ends of a host's cable have the rate.
for h in 0 1 2 3 4 5 6 7; do
    ip netns add "$prefix$h"
    ip -n "$hub" link add "port$h" type veth peer name eth0 netns "$prefix$h"
    ip -n "$hub" link set "port$h" master bridge up
    ip -n "$prefix$h" addr add "10.77.0.$((h + 1))/24" dev eth0
    ip -n "$prefix$h" link set eth0 up
    ip -n "$prefix$h" link set lo up
done
set_rate() {
    for h in 0 1 2 3 4 5 6 7; do
        tc -n "$prefix$h" qdisc replace dev eth0 root tbf rate "$1" burst 1mb latency 100ms
        tc -n "$hub" qdisc replace dev "port$h" root tbf rate "$1" burst 1mb latency 100ms
    done
}
sent_bytes() { # by all hosts
    for h in 0 1 2 3 4 5 6 7; do ip netns exec "$prefix$h" cat /sys/class/net/eth0/statistics/tx_bytes; done | awk '{sum += $1} END {print sum}'
}

# What mpirun calls in place of ssh: AGENT HOST COMMAND.
cat >agent <<'AGENT'
#!/usr/bin/env bash
host=$1
shift
exec ip netns exec "$host" unshare --uts bash -c "hostname $host; $*"
AGENT
chmod +x agent
hosts_build() { # RANKS OPTIONS: one rank a host
    local list=$prefix"0:1" h n=$1
    shift
    for ((h = 1; h < n; ++h)); do list+=,$prefix$h:1; done
    "$dir/agent" "${prefix}0" exec mpirun --host "$list" --mca plm_rsh_agent "$dir/agent" --mca pml ob1 --mca btl tcp,self \
        --mca btl_tcp_if_include eth0 --mca oob_tcp_if_include eth0 --bind-to none --wdir "$dir" -x OMP_NUM_THREADS \
        "$ISOSHADE" build "$@"
}

"$ISOSHADE" make noise --size "${size}x${size}x$size" -o v.nrrd -q || exit 1
"$ISOSHADE" build v.nrrd -o one.iso --levels 4 --memory 40 -q >/dev/null || exit 1
echo "noise $size^3, 16 bits, 4 levels, a thread a rank, $(nproc --all) cores; seconds are the build's own, without those in which mpirun starts it"
echo "| rate of each host | ranks | seconds | efficiency | sent, MB | by mpirun itself | bytes a voxel |"
echo "|---|---|---|---|---|---|---|"
for rate in "${rates[@]}"; do
    set_rate "$rate"
    base=
    for n in 1 2 4 8; do
        rm -rf many.iso
        before=$(sent_bytes)
        hosts_build $n --help >/dev/null 2>&1
        own=$(($(sent_bytes) - before))
        before=$(sent_bytes)
        hosts_build $n v.nrrd -o many.iso --levels 4 --memory 40 -q --json >out 2>err
        sent=$(($(sent_bytes) - before))
        seconds=$(json_number out total)
        base=${base:-$seconds}
        awk -v rate="$rate" -v n=$n -v s="$seconds" -v b="$base" -v sent=$sent -v own=$own -v size="$size" \
            'BEGIN { printf "| %s | %d | %.2f | %.2f | %.2f | %.2f | %.3f |\n", rate, n, s, b / s / n, sent / 1e6, own / 1e6,
             (sent > own ? sent - own : 0) / size ^ 3 }'
        check "${n}_ranks_on_${n}_hosts_at_${rate}_write_the_same_bytes" diff -rq one.iso many.iso
    done
done

# A rank of the last host is killed when the build has saved where it stands.
head -c $((2 * 320 * 320 * 1400)) /dev/zero >big.raw
big="big.raw --raw-size 320x320x1400 --raw-type uint16 --memory 30 --save-every 0 -q"
set_rate 1gbit
isoshade_on() { ip netns pids "$1" | while read -r p; do [ "$(cat "/proc/$p/comm")" = isoshade ] && echo "$p"; done 2>/dev/null; }
for ((try = 0; try < 20; ++try)); do
    rm -rf no.iso .no.iso.partial
    hosts_build 4 $big -o no.iso >out 2>err &
    job=$!
    while [ ! -e .no.iso.partial/progress.json ] && kill -0 $job 2>/dev/null; do sleep 0.02; done
    kill -9 $(isoshade_on "${prefix}3") 2>/dev/null
    wait $job
    code=$?
    [ -e no.iso ] && [ $code = 0 ] || break
done
echo "a rank was killed on its host: exit code $code; mpirun said: $(grep -m 1 -i 'signal' err)"
check a_killed_rank_ends_the_job_with_137 test $code = 137
check nothing_looks_finished test ! -e no.iso
check no_rank_is_left_on_another_host test -z "$(for h in 0 1 2 3; do isoshade_on "$prefix$h"; done)"
expect two_hosts_take_up_what_four_left 0 hosts_build 2 $big -o no.iso --resume --json
check from_where_they_stood grep -qE '"resumed_at_plane": [1-9]' out
"$ISOSHADE" build $big -o whole.iso >/dev/null
check to_the_same_bytes diff -rq whole.iso no.iso
printf 'x' | dd of=no.iso/level_1_dir.nrrd bs=1 seek=5000 conv=notrunc 2>/dev/null
notice one_byte_would_be_seen diff -rq whole.iso no.iso
exit $failed
