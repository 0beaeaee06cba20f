#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The line of progress as it is drawn: on a terminal in place and within its width, elsewhere line by line or not at all.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make marschner-lobb --size 30x30x30 -o v.nrrd -q || exit 1
# on_terminal COLUMNS TERM COMMAND: what a terminal of that width gets on stderr.
cat >terminal.py <<'PY'
import fcntl, os, pty, struct, subprocess, sys, termios
master, slave = pty.openpty()
fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 25, int(sys.argv[1]), 0, 0))
child = subprocess.Popen(sys.argv[3:], stdout=subprocess.DEVNULL, stderr=slave, env={**os.environ, "TERM": sys.argv[2]})
os.close(slave)
text = b""
while True:
    try:
        more = os.read(master, 4096)
    except OSError:
        break
    if not more:
        break
    text += more
sys.stdout.buffer.write(text)
sys.exit(child.wait())
PY
on_terminal() { python3 terminal.py "$@"; }
# Each picture of the line ends by wiping the rest, and is as wide as it may be.
narrow_enough() { tr '\r' '\n' <"$1" | sed 's/\x1b\[K//g' | awk -v most="$2" '{if (length($0) > most) bad = 1; if ($0 != "") ++n} END {exit !(n > 0 && !bad)}'; }

# percents FILE: of each picture of the line, in their order. How many are drawn depends on the machine's speed: the first
# report is always drawn, others a tenth of a second apart.
percents() { tr '\r' '\n' <"$1" | sed -nE 's/.* ([0-9]+) %, .*/\1/p'; }
never_falls() { percents "$1" >percents && test -s percents && sort -nc percents; }

palette=("$ISOSHADE" palette v.nrrd -o p.csv)
check it_runs_on_a_terminal on_terminal 80 xterm "${palette[@]}"
on_terminal 80 xterm "${palette[@]}" >wide
check the_line_has_the_command_percents_and_the_time grep -aqE 'palette: .* +[0-9]+ %, [0-9]+ s' wide
on_terminal 80 xterm "$ISOSHADE" render v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --size 96 --with reference -o r.exr >render
check a_render_has_them_too grep -aqE 'render: .* +[0-9]+ %, [0-9]+ s' render
check it_is_wiped_in_the_end python3 -c 'import sys; sys.exit(not open("wide", "rb").read().endswith(b"\r\x1b[K"))'
check it_is_one_line test "$(tr -cd '\n' <wide | wc -c)" = 0
check it_has_no_colors bash -c '! grep -aq "\[[0-9;]*m" wide'
on_terminal 24 xterm "${palette[@]}" >narrow
check it_is_cut_to_the_width narrow_enough narrow 23
notice a_line_that_is_too_wide narrow_enough wide 23

# ---- validate: parts side by side, a budget, scenes ----
validate=("$ISOSHADE" validate v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --with cpu --quick --levels 2 --size 16
    --level-views 2 --level-size 16)
on_terminal 80 xterm "${validate[@]}" -o whole >whole.line
check its_percents_never_fall never_falls whole.line
on_terminal 80 xterm "${validate[@]}" --budget 600 -o budget >budget.line
check nor_with_a_budget never_falls budget.line
mkdir scenes && cp "$top"/refscenes/suite/{constant,empty}*.scene.json scenes
on_terminal 80 xterm "$ISOSHADE" validate --suite scenes --with cpu --quick --size 96 -o suite >suite.line
check nor_with_scenes never_falls suite.line
printf 'a: b   50 %%, 1 s\ra: b   49 %%, 1 s\r' >fell
notice one_that_falls never_falls fell

on_terminal 80 xterm "${palette[@]}" --quiet >quiet
check quiet_is_silent test ! -s quiet
on_terminal 80 dumb "${palette[@]}" >dumb
check a_terminal_that_cannot_go_back_gets_no_control_characters bash -c '! grep -aq "$(printf "\033")" dumb'
began=$SECONDS
"${palette[@]}" >out 2>log
check without_a_terminal_it_is_silent_for_half_a_minute test "$(wc -l <log)" -le $(((SECONDS + 1 - began) / 30))
exit $failed
