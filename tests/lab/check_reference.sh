#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# isoshade-lab reference, and the bound that render prints.
. "$(dirname "$0")/../lib.sh"
"$ISOSHADE" make shells --size 20 -o "$dir/shells.nrrd" -q
"$LAB" reference "$dir/shells.nrrd" --size 8 --json -q >"$dir/bench.json"
scene=$top/refscenes/shells.scene.json
"$ISOSHADE" render "$dir/shells.nrrd" --scene "$scene" --size 8 --with reference --json -q -o "$dir/a.exr" >"$dir/converged.json"
"$ISOSHADE" render "$dir/shells.nrrd" --scene "$scene" --size 8 --with reference --quadrature midpoint --json -q -o "$dir/b.exr" >"$dir/midpoint.json"
"$ISOSHADE" render "$dir/shells.nrrd" --scene "$scene" --size 8 --with reference --shading-from flipped --json -q -o "$dir/c.exr" >"$dir/other.json"
"$ISOSHADE" validate "$dir/shells.nrrd" --scene "$scene" --quick --with reference,gl --levels 1 --size 8 -q -o "$dir/report" >/dev/null
check "pictures with and without are one, in less time, within a proved bound" python3 - "$dir" <<'PY'
import json, sys
load = lambda name: json.load(open(f'{sys.argv[1]}/{name}.json'))
b = load('bench')
assert b['schema'] == 'isoshade-lab.reference/1' and len(b['rows']) == 8
for row in b['rows']:
    if row['rule'] == 'midpoint':
        assert row['difference'] == 0 and 'error_bound' not in row
    else:
        assert 0 < row['error_bound'] <= 1e-9 and row['error_bound_is_proved']
        assert row['difference'] < 1e-5  # what halving estimates wrongly
assert b['mean_ratio']['converged'] > 2
c, m, o = load('converged'), load('midpoint'), load('other')
assert 0 < c['error_bound'] <= 1e-9 and c['error_bound_is_proved']
assert 'error_bound' not in m
r = json.load(open(f'{sys.argv[1]}/report/report.json'))['reference']['level-0-codes']
assert 0 < r['error_bound'] <= 1e-9 and r['error_bound_is_proved']
assert o['error_bound'] > 0 and not o['error_bound_is_proved']
PY
expect "no volume is bad usage" 2 "$LAB" reference
expect "no pixels are bad usage" 2 "$LAB" reference "$dir/shells.nrrd" --size 0
exit $failed
