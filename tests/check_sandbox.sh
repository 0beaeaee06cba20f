#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What a program that is started may do: no more than its work needs. Planted ones try more, and say what they came to; the
# same ones without the sandbox succeed.
. "$(dirname "$0")/lib.sh"
isoshade() { "$ISOSHADE" "$@"; }
has_landlock() { isoshade list | grep -q 'into folders of their own alone (Landlock'; }
shortens() { if isoshade list | grep -q 'lets them shorten'; then echo yes; else echo no; fi; } # before Linux 6.2
has_seccomp() { isoshade list | grep -q 'use no network (seccomp)'; }
mkdir outside bin
isoshade make shells --size 9 -q -o s.nrrd || exit 1
python_with socket

# What a program could do; a line "error: ..." is what isoshade shows of a program that fails.
cat >try.sh <<END
#!/bin/bash
case "\$*" in *-version*) echo "POV-Ray 3.7.0.10"; exit 0 ;; esac
outside=$dir/outside
can() { if "\$@" >/dev/null 2>&1; then echo yes; else echo no; fi; }
write() { echo x >"\$1"; }
echo x >own
echo "error: makes \$(can write \$outside/new.\$\$) shortens \$(can truncate -s 0 \$outside/there)" \\
     "removes \$(can rm \$outside/gone) renames \$(can mv own \$outside/own) links \$(can ln -s / \$outside/link.\$\$)" \\
     "own \$(can write \$TMPDIR/own) reads \$(can cat \$outside/there)" \\
     "network \$(can $python -c 'import socket; socket.socket()')" \\
     "unix \$(can $python -c 'import socket; socket.socket(socket.AF_UNIX)')" \\
     "raw \$(can $python -c 'import socket; socket.socket(socket.AF_NETLINK, socket.SOCK_RAW)')" \\
     "pair \$(can $python -c 'import socket; socket.socketpair()')" \\
     "datagrams \$(can $python -c 'import socket; socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)')" \\
     "rights \$(can chmod 600 \$outside/there) owner \$(can chown \$(id -u) \$outside/there)" \\
     "times \$(can $python -c 'import os, sys; os.utime(sys.argv[1], (1, 1))' \$outside/there)" \\
     "tmpdir \$([ \$(realpath "\$TMPDIR") = \$PWD ] && echo own) home \$([ \$(realpath "\$HOME") = \$PWD ] && echo own || echo user)"
exit 1
END
chmod +x try.sh
cp try.sh bin/povray
said() { # COMMAND ...: what the program says of itself
    echo x >outside/there && echo x >outside/gone && rm -f outside/own
    "$@" 2>&1 >/dev/null | grep -o 'makes .*'
}
scene=$top/refscenes/shells.scene.json
povray() { said env ISOSHADE_POVRAY="$dir/bin/povray" "$ISOSHADE" render s.nrrd --scene "$scene" --with povray --size 8 -q -o o.exr "$@"; }
cat >r.json <<'END'
{"schema": "isoshade.renderers/1", "renderers": [
 {"name": "in", "command": ["./try.sh"], "tier": "limit", "can": ["lights"]},
 {"name": "out", "command": ["./try.sh"], "tier": "limit", "can": ["lights"], "sandbox": false}]}
END
external() { said "$ISOSHADE" render s.nrrd --scene "$scene" --with "$1" --renderers r.json --size 8 -q -o o.exr "${@:2}"; }
is() { # NAME WANTED IS
    if [ "$3" = "$2" ]; then ok "$1"; else not_ok "$1" "it says: $3"; fi
}
files() { echo "makes $1 shortens $2 removes $1 renames $1 links $1 own yes reads yes"; }
if has_landlock && has_seccomp; then
    is povray_may_write_and_talk_nowhere_else "$(files no "$(shortens)") network no unix no raw no pair yes datagrams no rights no owner no times no tmpdir own home own" "$(povray)"
    is a_renderer_of_somebody_may_speak_to_a_display "$(files no "$(shortens)") network no unix yes raw no pair yes datagrams yes rights yes owner yes times yes tmpdir own home user" "$(external in)"
    check what_they_tried_left_nothing test "$(ls outside)" = "$(printf 'gone\nthere')"
else
    skip a_sandbox_that_holds "$(isoshade list | sed -n '/^sandbox:/{n;s/^ *//p}')"
fi
# Planted: the same programs without it, in each of the three ways to say so.
all="$(files yes yes) network yes unix yes raw yes pair yes datagrams yes rights yes owner yes times yes"
without() { sed 's/ tmpdir .*//'; }
export TMPDIR=$dir # TMPDIR of the caller is kept then
is without_a_sandbox_povray_may_all "$all" "$(povray --no-sandbox | without)"
is as_by_the_environment "$all" "$(ISOSHADE_SANDBOX=off povray | without)"
is a_row_of_renderers_json_says_so "$all" "$(external out | without)"
check a_sandbox_that_is_off_is_told grep -q 'off: other programs have all rights of yours' <(isoshade list --no-sandbox)

# ---- readers of other libraries' formats are programs, too: a damaged file may make one do anything but write and talk ----
mkdir beside
cp "$(readlink -f "$ISOSHADE")" beside/isoshade
echo x >outside/rights && chmod 600 outside/rights
printf '#!/bin/sh\nchmod 644 %s/outside/rights\necho x >%s/outside/read\n' "$dir" "$dir" >beside/isoshade-vdb
chmod +x beside/isoshade-vdb
cp "$top/tests/fuzz/seeds/vdb/v.vdb" v.vdb
if has_landlock; then
    beside/isoshade info v.vdb >/dev/null 2>&1
    check a_reader_may_write_nothing test ! -e outside/read
fi
if has_seccomp; then check nor_change_the_rights_of_files test "$(stat -c %a outside/rights)" = 600; fi
beside/isoshade info v.vdb --no-sandbox >/dev/null 2>&1
check without_a_sandbox_it_may test -e outside/read -a "$(stat -c %a outside/rights)" = 644

# ---- VTK on a display: what it starts as python3 may no more than draw there ----
python_with vtkmodules.vtkRenderingVolumeOpenGL2,numpy
if command -v xvfb-run >/dev/null && "$python" -c 'import vtkmodules, numpy' 2>/dev/null; then
    mkdir python && printf '#!/bin/sh\necho x >>%s/outside/python\nexec %s "$@"\n' "$dir" "$(command -v "$python")" >python/python3
    chmod +x python/python3
    sed 's/"diffuse": [0-9.]*/"diffuse": 0/; s/"specular": [0-9.]*/"specular": 0/' "$scene" >unlit.scene.json
    cp "${scene%.scene.json}.tf.json" .
    by_vtk() { PATH=$dir/python:$PATH "$@" "$ISOSHADE" render s.nrrd --scene unlit.scene.json --with vtk-gpu --renderers "$top/tests/peers/vtk.json" --size 16 -q -o "vtk.exr"; }
    check vtk_draws_on_a_display_in_the_sandbox by_vtk xvfb-run -a
    if has_landlock; then check and_writes_nowhere_else test ! -e outside/python; fi
else
    skip vtk_on_a_display "python3-vtk9 or xvfb is not installed"
fi

# ---- Chromium has sandboxes of its own, and begins as root without them alone ----
chmod 755 . && mkdir -m 777 browser && cp "$top/tests/peers/chromium.py" browser
cat >browser/chromium <<'END'
#!/bin/sh
case " $* " in *' --no-sandbox '*) echo without ;; *) echo within ;; esac >"$SAID"
head -c 1 <&3 >/dev/null # the first byte that it is sent
END
chmod 755 browser/chromium
browser() { # COMMAND ...: with or within its sandboxes, by what it is started with
    rm -f browser/said
    SAID=$dir/browser/said TMPDIR=$dir/browser ISOSHADE_CHROMIUM=$dir/browser/chromium "$@" "$python" -B -c '
import sys
sys.path.insert(0, sys.argv[1])
from chromium import Chromium
try: Chromium()
except RuntimeError as problem: print(problem)' "$dir/browser" >browser/out 2>&1
    cat browser/said
}
if [ "$(id -u)" = 0 ]; then
    is a_browser_of_root_begins without "$(browser)"
    if command -v setpriv >/dev/null; then somebody=(setpriv --reuid 65534 --regid 65534 --clear-groups); fi
else
    somebody=(env)
fi
if [ -n "${somebody+known}" ]; then
    is a_browser_keeps_its_sandboxes within "$(browser "${somebody[@]}")"
    check that_it_may_lack_them_is_said grep -q 'the browser ended; where it may make no sandboxes, --no-sandbox' browser/out
    is and_goes_without_where_that_is_asked_for without "$(ISOSHADE_SANDBOX=off browser "${somebody[@]}")"
else
    skip a_browser_keeps_its_sandboxes "setpriv is not installed"
fi
check a_browser_that_ends_at_once_leaves_no_folder test -z "$(find browser -name 'isoshade-chromium.*')"

# ---- pictures by gnuplot stand outside of its folder, which it may write to alone ----
isoshade tf show "$top/refscenes/hero.tf.json" -o tf.png -q
check gnuplot_draws_where_it_was_told test -s tf.png
exit $failed
