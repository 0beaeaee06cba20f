#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Mutation testing of the verdict: is each mistake that is planted in the code that judges noticed by a test? The mistakes
# stand in tests/mutants.txt, whose head says how. One at a time goes into a copy of the checkout; what it touches is built,
# and tests run until one fails: the mutant is killed. One that passes them all has survived.
#
#   tests/mutants.sh [--check] [WORDS]     mutants whose name holds WORDS; all without
#
#   --check    only whether each mutant still fits the code: its text is there once, and what is put for it differs
#
# Ends with one line of sums, and with 1 where a mutant survived that is not listed as one that may. Results are kept in
# build/mutants/results.
set -u
cd "$(dirname "$0")/.." || exit 1
. tests/environment.sh
top=$PWD list=$PWD/tests/mutants.txt work=$PWD/build/mutants

check_only=
if [ "${1-}" = --check ]; then check_only=1 && shift; fi
[ $# -le 1 ] || { sed -n 's/^#   \(tests.*\)/usage: \1/p' "$0" >&2; exit 2; }
words=${1-}

# fields NUMBER: of one mutant, as shell variables; plant NUMBER FOLDER: puts it into the copy in FOLDER.
mutants() { python3 - "$list" "$@" <<'END'; }
import re, shlex, sys
path, command, *rest = sys.argv[1:]
mutants, common = [], []
for number, line in enumerate(open(path), 1):
    line = line.rstrip("\n")
    if line.startswith("#") or not line:
        continue
    if line.startswith("= "):
        mutants.append({"name": line[2:], "line": number})
        continue
    key, _, value = line.partition(": ")
    if key == "tests" and not mutants:
        common = value.split()
    elif mutants and key in ("file", "old", "new", "by", "survives") and key not in mutants[-1]:
        mutants[-1][key] = value
    else:
        sys.exit(f"{path}:{number}: \"{key}\" is not known here")

def text(m, key):
    return m.get(key, "").replace("\\n", "\n")

def plant(m, folder):
    source = open(f"{folder}/{m['file']}").read()
    found = source.count(text(m, "old"))
    if not m.get("old") or found != 1:
        raise ValueError(f"its text stands {found} times in {m['file']}, wanted once")
    if text(m, "old") == text(m, "new"):
        raise ValueError("it changes nothing")
    return source.replace(text(m, "old"), text(m, "new"))

if command == "check":
    names, misfits = [m["name"] for m in mutants], 0
    for m in mutants:
        try:
            plant(m, rest[0])
            if names.count(m["name"]) > 1:
                raise ValueError("another one is called so")
        except (OSError, ValueError) as why:
            print(f"{path}:{m['line']}: {m['name']}: {why}", file=sys.stderr)
            misfits += 1
    if misfits:
        sys.exit(1)
    print(f"{len(mutants)} mutants fit the code")
elif command == "numbers":
    print(*(i for i, m in enumerate(mutants) if rest[0] in m["name"]))
elif command == "tests":
    print(*common)
elif command == "fields":
    m = mutants[int(rest[0])]
    first = m.get("by", "").split()
    print("name=" + shlex.quote(m["name"]), "file=" + shlex.quote(m["file"]), "survives=" + shlex.quote(m.get("survives", "")),
          "tests=" + shlex.quote(" ".join(first + [t for t in common if t not in first])))
elif command == "plant":
    m = mutants[int(rest[0])]
    changed = plant(m, rest[1])
    open(f"{rest[1]}/{m['file']}", "w").write(changed)
END

mutants check "$top" || exit 1
[ -z "$check_only" ] || exit 0

# The checkout as it is, what is not committed too, without what was built.
copy() { # FOLDER
    mkdir -p "$1" && git ls-files -z --cached --others --exclude-standard | tar --null -T - -cf - | tar -xf - -C "$1" || return 1
    # A run that was ended left its mutant's object, which is newer than the file.
    [ ! -e "$1.logs/planted" ] || touch "$1/$(cat "$1.logs/planted")"
}
build() { make --no-print-directory SETUP=no "$@" >"$logs/build" 2>&1; }

# passes TEST: builds it, and runs it (of the product, else of the lab) against the program of the copy, with the
# libraries that lie beside that
passes() {
    case $1 in
    check_*)
        script=tests/$1.sh
        [ -e "$script" ] || script=tests/lab/$1.sh
        build all lab && timeout 900 env ISOSHADE="$PWD/build/release/isoshade" bash "$script" >"$logs/test" 2>&1
        ;;
    *) build all "build/release/tests/$1" && timeout 900 "build/release/tests/$1" >"$logs/test" 2>&1 ;;
    esac </dev/null
}

# Takes numbers from the queue until it is empty.
worker() { # FOLDER
    local number name file survives tests test verdict
    logs=$1.logs && mkdir -p "$logs"
    cd "$1" || exit 1
    export HOME=$1.home && mkdir -p "$HOME"
    while number=$(flock "$work/lock" sh -c "head -n 1 '$work/queue'; sed -i 1d '$work/queue'") && [ -n "$number" ]; do
        eval "$(mutants fields "$number")"
        cp "$file" "$logs/original"
        echo "$file" >"$logs/planted"
        mutants plant "$number" .
        verdict=SURVIVED
        if ! build all; then
            verdict='killed by the compiler'
        else
            for test in $tests; do
                passes "$test" || { verdict="killed by $test"; break; }
            done
        fi
        cat "$logs/original" >"$file" # with a new time, so that it is built again
        rm "$logs/planted"
        [ "$verdict" != SURVIVED ] || [ -z "$survives" ] || verdict="survived, as it may: $survives"
        printf '%s: %s: %s\n' "$file" "$name" "$verdict" | tee -a "$work/results"
    done
}

rm -rf "$work/results" "$work/queue" && mkdir -p "$work"
: >"$work/results"
mutants numbers "$words" | tr ' ' '\n' >"$work/queue"
slots=$(nproc)
for ((i = 0; i < slots; ++i)); do
    copy "$work/tree-$i" || exit 1
    # The same folders above it as the checkout has: tests find the real volumes there.
    [ ! -e "$top/../shared" ] || ln -sfn "$(realpath "$top/../shared")" "$work/shared"
done

# A test that fails without a mutant would kill them all.
healthy() { # FOLDER
    local test
    logs=$1.logs && mkdir -p "$logs" && cd "$1" || return 1
    for test in $(mutants tests); do
        passes "$test" || { echo "mutants: $test fails without a mutant (build/mutants/${logs##*/}/test)" >&2; return 1; }
    done
}
(healthy "$work/tree-0") || exit 1
for ((i = 0; i < slots; ++i)); do worker "$work/tree-$i" & done
wait

count() { grep -cE ": $1" "$work/results"; }
printf '%d mutants: %d killed, %d survived as they may, %d survived\n' "$(wc -l <"$work/results")" "$(count 'killed by ')" \
    "$(count 'survived, as it may')" "$(count 'SURVIVED$')"
! grep -q ': SURVIVED$' "$work/results"
