#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# campaign.sh GOAL [READER ...]: each reader in turn until it took GOAL damaged files, in pieces of FUZZ_PIECE seconds (30).
# By the release's driver, which has no sanitizers and takes many times as many a second as `make fuzz`: it meets crashes,
# broken contracts and inputs that take too long. Readers that are programs of their own are called within the driver; what
# would end such a program is counted. Every piece has a seed of its own; what was done stands in
# build/fuzzed/counts, so that a run that is ended goes on from there. FUZZ_UNTIL=HHMM begins no piece after that time.
#
# campaign.sh --table: a row a reader of what was done, with the runs of `make fuzz`. Exit code 1: something was found.
set -u
cd "$(dirname "$0")/../.."
top=$PWD out=${FUZZ_OUT:-$PWD/build/fuzzed} fuzz=$PWD/build/release/isoshade-fuzz
. tests/fuzz/programs.sh
counts=$out/counts
mkdir -p "$out"
touch "$counts"
export OMP_NUM_THREADS=1 LD_BIND_NOW=1 # symbols are looked up once, not by each process that goes on

# Lines of counts: READER HOW SEED EXECUTIONS SECONDS, how many ended the reader's program or -, and how many it read as good
# files; or READER HOW SEED found.
table() {
    echo '| reader | executions, release | read as good files | with sanitizers | seconds | ended its program | found |'
    echo '|---|---|---|---|---|---|---|'
    awk '{ if ($4 == "found") found[$1]++; else if ($2 == "release") plain[$1] += $4; else checked[$1] += $4
           seconds[$1] += $5; names[$1] = 1; if ($6 ~ /[0-9]/) ended[$1] += $6; if ($7 != "") good[$1] += $7 }
         END { for (n in names) printf "| %s | %d | %s | %d | %.0f | %s | %d |\n", n, plain[n], good[n], checked[n], seconds[n], ended[n], found[n] }' "$counts" | sort
    ! grep -q ' found$' "$counts"
}
[ "${1-}" != --table ] || { table; exit; }
goal=${1:?campaign.sh GOAL [READER ...], or --table}
shift

total_of() { awk -v name="$1" '$1 == name && $2 == "release" && $4 != "found" { sum += $4 } END { printf "%d", sum }' "$counts"; }
# A seed for each piece: how many there were, and one.
seed_of() { awk -v name="$1" '$1 == name && $2 == "release" { n++ } END { print n + 1 }' "$counts"; }
# An input that stops the driver stays as build/fuzzed/READER-release-SEED; the next run goes on with the next seed.
piece() { # READER EXECUTIONS
    local seed said ended=-
    seed=$(seed_of "$1")
    said=$(cd "$out" && "${FUZZ_DRIVER:-$fuzz$(driver_of "$1")}" "$1" "$top/tests/fuzz/seeds/$1" "$2" "${FUZZ_PIECE:-30}" "$seed" 2>"$out/$1-release.log")
    [[ $said =~ ([0-9]+)\ inputs\ ended ]] && ended=${BASH_REMATCH[1]}
    if [[ $said =~ ([0-9]+)\ mutations,\ +([0-9]+)\ read\ +([0-9.]+)\ s$ ]]; then
        echo "$1 release $seed ${BASH_REMATCH[1]} ${BASH_REMATCH[3]} $ended ${BASH_REMATCH[2]}" >>"$counts"
        [ "${BASH_REMATCH[1]}" -gt 0 ]
    else
        echo "$1 release $seed found" >>"$counts"
        mv "$out/crash-$1" "$out/$1-release-$seed" 2>/dev/null
        echo "$1: seed $seed: $(grep -a -m 1 'a contract' "$out/$1-release.log") $out/$1-release-$seed" >&2
        return 1
    fi
}

for name in ${*:-$("$fuzz" --list | cut -d' ' -f1 | grep -v planted)}; do
    while total=$(total_of "$name") && [ "$total" -lt "$goal" ]; do
        [ -z "${FUZZ_UNTIL-}" ] || [ "$(date +%H%M)" -lt "$FUZZ_UNTIL" ] || break 2
        piece "$name" $((goal - total)) || break
    done
done
table
