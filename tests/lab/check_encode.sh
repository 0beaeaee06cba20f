#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# isoshade-lab encode: the keys that the design fixes, the paper's figures, and bad usage.
. "$(dirname "$0")/../lib.sh"
"$LAB" encode --count 500 --chart "$dir" --json >"$dir/out.json"
check "Figure 10 is drawn" test -s "$dir/figure10.svg"
check "the report has the design's keys and the paper's holes" python3 - "$dir/out.json" <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
keys = ['name', 'bytes', 'encode_million_per_second', 'decode_million_per_second', 'hole_deg', 'max_error_deg',
        'mean_error_deg', 'filtered_mean_error_deg', 'filtered_max_error_deg']
schemes = {s['name']: s for s in report['schemes']}
for s in report['schemes']:
    for key in keys:
        assert key in s, (s['name'], key)
assert abs(schemes['region48']['hole_deg'] - 0.17303) < 1e-4
assert abs(schemes['cube']['hole_deg'] - 0.31776) < 1e-4
default = schemes['fit']  # of `build`; a mean of 500 is right to 3 %
assert default['filtered_mean_error_deg'] <= 0.1 and default['filtered_max_error_deg'] <= 0.5 and default['max_error_deg'] <= 0.33
assert schemes['snorm']['filtered_mean_error_deg'] > 0.12 and schemes['snorm']['max_error_deg'] > 0.33  # the planted fault
stiffness = {round(row['mu'], 2): row['filtered_15_mean_error_deg'] for row in report['stiffness']}
assert stiffness[0.08] < stiffness[0.15] < stiffness[1.0]
assert abs(report['convexity']['counter_example']['off_arc_deg'] - 1.96) < 0.01
assert abs(report['table1']['best_lambda']['lambda'] - 0.61) < 0.01
PY
"$ISOSHADE" make marschner-lobb --size 24 -o "$dir/ml.nrrd" -q
"$LAB" encode "$dir/ml.nrrd" --scene "$top/refscenes/marschner-lobb.scene.json" --size 32 --levels 2 --json -q >"$dir/images.json"
check "in images a lost length costs more than bytes do" python3 - "$dir/images.json" <<'PY'
import json, sys
report = json.load(open(sys.argv[1]))
rmse = {(i['method'], i['level']): i['rmse'] for i in report['images']}
assert 0 < rmse['half', 1] < rmse['snorm', 1] and rmse['half', 1] < rmse['fit', 1] < 1e-2
for lossy in ['shell', 'region48', 'fit, byte of L, filtered apart']:  # the planted faults
    assert rmse[lossy, 1] > 5 * rmse['fit', 1], lossy
assert len(report['image_ratios']) == 2 * 8
PY
expect "a scene that is not there is an I/O error" 3 "$LAB" encode "$dir/ml.nrrd" --scene none.json
expect "an unknown benchmark is bad usage" 2 "$ISOSHADE" bench nothing
expect "a count out of range is bad usage" 2 "$LAB" encode --count 1
expect "a folder that is not there is an I/O error" 3 "$LAB" encode --count 500 --chart "$dir/none"
exit $failed
