# SPDX-License-Identifier: MIT
# lib.sh - sourced by the check scripts. Leaves the shell in a private folder $dir, knows the project's $top and the
# program $ISOSHADE. Cases print "ok NAME" or "not ok NAME: why"; a script ends with `exit $failed`.
set -u
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
ISOSHADE=$(realpath -s "${ISOSHADE:-$top/isoshade}")
LAB=$ISOSHADE-lab # the program of src/lab
export ISOSHADE LAB
dir=$(mktemp -d) HOME=$(mktemp -d)
export HOME
trap 'rm -rf "$dir" "$HOME"' EXIT
cd "$dir" || exit 1
failed=0
ok() { echo "ok $1"; }
# python_with MODULES: $python becomes one that has them: Debian's own, where another one comes first in the PATH
python_with() { python=python3; "$python" -c "import $1" 2>/dev/null || python=/usr/bin/python3; }
skip() { echo "ok $1 # SKIP $2"; }
# A case that fails because the program says by name what this system's Blender lacks is skipped with that sentence.
not_ok() {
    if [[ $2 == *"built without NanoVDB"* ]] && ! has_cycles; then skip "$1" "$lack"; else echo "not ok $1: $2"; failed=1; fi
}

# check NAME COMMAND: it has to succeed
check() {
    local name=$1 output
    shift
    if output=$("$@" 2>&1 | tr -d '\0'; exit "${PIPESTATUS[0]}"); then ok "$name"; else not_ok "$name" "$*: $(tail -n 2 <<<"$output")"; fi
}

# expect NAME CODE COMMAND: the exit code; its output is left in $dir/out and $dir/err
expect() {
    local name=$1 wanted=$2 code
    shift 2
    "$@" >"$dir/out" 2>"$dir/err"
    code=$?
    if [ $code = "$wanted" ]; then ok "$name"; else not_ok "$name" "exit code $code, wanted $wanted: $(tail -n 1 "$dir/err")"; fi
}

# notice NAME COMMAND: a planted fault, which the command has to fail at
notice() {
    local name=$1
    shift
    if "$@" >/dev/null 2>&1; then not_ok "$name" "it passes: $*"; else ok "$name"; fi
}

# The largest memory of a command in KB; measured only if has_peak.
peak() { /usr/bin/time -f %M -o peak "$@" >/dev/null 2>&1 && cat peak; }
has_peak() { [ -x /usr/bin/time ] && [[ $(nm -D "$ISOSHADE" 2>/dev/null) != *__asan* ]]; }
# json_number FILE KEY: the first number of that key
json_number() { sed -n "s/.*\"$2\": \([-0-9.e+]*\),*$/\1/p" "$1" | head -n 1; }

# holds NAME CONDITION: of numbers, as awk writes it; one that lacks a number fails
holds() { if awk "BEGIN { exit !($2) }" 2>/dev/null; then ok "$1"; else not_ok "$1" "$2"; fi; }

# has_keys NAME FILE KEY ...: a case NAME_KEY each, that the JSON has the key
has_keys() {
    local name=$1 file=$2 key
    shift 2
    for key in "$@"; do check "${name}_$key" grep -q "\"$key\":" "$file"; done
}

# has_files NAME FOLDER FILE ...: a case NAME_FILE each, that the file is there and not empty
has_files() {
    local name=$1 folder=$2 file
    shift 2
    for file in "$@"; do check "${name}_$file" test -s "$folder/$file"; done
}

# refuse NAME CODE WORDS COMMAND: the exit code, one line on stderr that holds the words, nothing on stdout, no file left
refuse() {
    local name=$1 wanted=$2 words=$3 code before after
    shift 3
    : >"$dir/out" && : >"$dir/err"
    before=$(find "$dir" | sort)
    "$@" >"$dir/out" 2>"$dir/err"
    code=$?
    # Lines of progress come after half a minute: on a slow machine, and not on others.
    sed -i -E '/^[a-z ]+: .* [0-9]+ %, [0-9]+ (s|min [0-9]+ s)$/d' "$dir/err"
    after=$(find "$dir" | sort)
    if [ $code != "$wanted" ]; then not_ok "$name" "exit code $code, wanted $wanted: $(cat "$dir/err")"
    elif [ "$(wc -l <"$dir/err")" != 1 ]; then not_ok "$name" "$(wc -l <"$dir/err") lines on stderr, wanted 1: $(cat "$dir/err")"
    elif ! grep -qF -- "$words" "$dir/err"; then not_ok "$name" "stderr lacks \"$words\": $(cat "$dir/err")"
    elif [ -s "$dir/out" ]; then not_ok "$name" "wrote on stdout: $(head -n 1 "$dir/out")"
    elif [ "$before" != "$after" ]; then not_ok "$name" "files were left: $(diff <(echo "$before") <(echo "$after"))"
    else ok "$name"; fi
}

# has_cycles: whether Cycles of this Blender shows volumes, for cases that follow from a picture of it; $lack says why not.
# Only Blender 5 and later can be built without. A Blender that is missing is a failure of the tests.
has_cycles() {
    if [ -z "${lack+known}" ]; then
        lack=
        if [ "$(blender --version 2>/dev/null | sed -n 's/^Blender \([0-9]*\)\..*/\1/p')" -ge 5 ] 2>/dev/null; then
            "$ISOSHADE" make shells --size 4 -q -o lack.nrrd
            lack=$("$ISOSHADE" render lack.nrrd --scene "$top/refscenes/shells.scene.json" --with cycles --size 4 -q -o lack.exr 2>&1 |
                grep -o 'Blender [0-9.]* of this system is built without NanoVDB.*')
            rm -f lack.nrrd lack.exr
        fi
    fi
    [ -z "$lack" ]
}
