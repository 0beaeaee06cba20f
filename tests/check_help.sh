#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# --help of each command shows at most 20 options and names the others; --help=all explains all.
. "$(dirname "$0")/lib.sh"

# The options that a help text explains: it gives each a line of its own.
explained() { sed -n '/^options:/,/^$/s/^  \(-., \|    \)--\([a-z0-9-]*\)\(=[^ ]*\)\?\( .*\)\?$/\2/p' "$1" | sort; }
# Those that it names alone.
named() { sed -n '/^more options;/,/^$/p' "$1" | sed 1d | grep -oE -- '--[a-z0-9-]+' | grep -v -- '--help' | sed 's/^--//' | sort; }
few() { [ "$(explained "$1" | wc -l)" -gt 0 ] && [ "$(explained "$1" | wc -l)" -le 20 ]; }
whole() { diff <(sort <(explained short.txt) <(named short.txt)) <(explained all.txt); }

{ "$ISOSHADE" --help; "$ISOSHADE" bench --help; } >commands.txt
commands=$(sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p; /^benchmarks:/,/^$/s/^  \([a-z-]*\) .*/bench \1/p' commands.txt | grep -vx bench)
check commands_are_found test "$(wc -l <<<"$commands")" -gt 20
check at_most_six_benchmarks test "$(grep -c '^bench ' <<<"$commands")" -le 6
while read -r command; do
    "$ISOSHADE" $command --help >short.txt && "$ISOSHADE" $command --help=all >all.txt
    check "${command// /_}_has_at_most_20_options" few short.txt
    check "${command// /_}_names_or_explains_each_option" whole
done <<<"$commands"

# Planted faults: an option more than 20, and one that is neither explained nor named.
"$ISOSHADE" render --help >short.txt && "$ISOSHADE" render --help=all >all.txt
notice a_help_with_all_options_is_too_long few all.txt
sed -i 's/ --roi / /' short.txt
notice an_option_that_is_left_out_is_found whole
# A name in a command's list that no option has would show nothing.
common_of() { sed -n 's/^ *\.common = "\(.*\)",$/\1/p' "$1" | tr ' ' '\n'; }
for file in "$top"/src/cli/cmd_*.c "$top"/src/bench/*.c; do
    for name in $(common_of "$file"); do grep -qhE "\"$name\", ('.'|0)," "$file" "$top"/src/options/*.[ch] "$top"/src/cli/*.h || bad="${bad-} ${file##*/}:$name"; done
done
check each_common_option_is_an_option test -z "${bad-}"
exit $failed
