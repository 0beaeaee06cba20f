#!/bin/bash
# SPDX-License-Identifier: MIT
# bench all: figures of small runs, a page, another program in turn. bench compare: closed forms, planted slowness, noise.
. "$(dirname "$0")/lib.sh"
python_with json
expect figures_are_measured 0 "$ISOSHADE" bench all --quick --repeat 2 --only build-memory,vdb-peak,build-files \
    --beside "$ISOSHADE,other.json" -o ours.json --page page.html --json -q
check they_have_all_that_a_reader_needs "$python" - <<'E'
import json
ours, other, out = (json.load(open(name)) for name in ('ours.json', 'other.json', 'out'))
assert out == ours and ours['schema'] == 'isoshade.bench.all/1' and ours['session'] == other['session']
rows = {r['name']: r for r in ours['headlines']}
assert list(rows) == ['build-memory', 'build-files', 'vdb-peak'], list(rows)
for r in rows.values():
    assert len(r['values']) == 2 and min(r['values']) > 0 and r['met'] is None and r['bar'] > 0, r
    assert abs(r['median'] - sum(r['values']) / 2) < 1e-6 * r['median'], r
    assert r['command'].startswith(('bench build', 'export')), r
assert 1e6 < rows['vdb-peak']['median'] < 1e9, rows['vdb-peak']  # of a process, in bytes
assert ours['machine']['cores'] >= 1 and ours['threads'] >= 1
E
check the_page_holds_them grep -q '"build-memory"' page.html
check and_no_mark_is_left sh -c '! grep -q "@[A-Z]*@" page.html'
expect what_fails_says_why 0 env ISOSHADE_BLENDER=/nowhere "$ISOSHADE" bench all --quick --repeat 1 --only blend-peak -q
check by_its_cause grep -q 'ISOSHADE_BLENDER' out

# Answers of known values: the factor, its interval and the verdict.
"$python" - <<'E'
import json, math, random
random.seed(1)
noise = [math.exp(random.gauss(0, .02)) for _ in range(10)]
def write(name, rows, session):
    head = {'schema': 'isoshade.bench.all/1', 'session': session, 'machine': {'cores': 2}}
    head['headlines'] = [{'name': n, 'command': 'c ' + n, 'lower_is_better': lower, 'values': v} for n, lower, v in rows]
    json.dump(head, open(name, 'w'))
even, odd = noise[0::2], noise[1::2]
drift = [1, 2, 4, 8, 16]  # the machine becomes slower and slower
write('a.json', [('same', True, even), ('slower', True, even), ('faster', True, even), ('rate', False, even), ('noisy', True, [1, 2, 1, 2, 1]),
                 ('small', True, even), ('known', True, [1, math.e])], 'one')
write('b.json', [('same', True, odd), ('slower', True, [1.1 * x for x in odd]), ('faster', True, [.9 * x for x in odd]),
                 ('rate', False, [.8 * x for x in odd]), ('noisy', True, [2, 1, 2, 1, 2]), ('small', True, [1.02 * x for x in even]),
                 ('known', True, [math.e, math.e ** 4])], 'two')
write('a-drift.json', [('drift', True, drift)], 'one')
write('b-drift.json', [('drift', True, [1.1 * d * (1 + .001 * i) for i, d in enumerate(drift)])], 'one')
write('c-drift.json', [('drift', True, [1.1 * d * (1 + .001 * i) for i, d in enumerate(drift)])], 'two')
write('once.json', [('same', True, [1.0])], 'one')
write('none.json', [], 'one')
E
expect what_became_slower_is_found 1 "$ISOSHADE" bench compare a.json b.json --json
check each_by_its_verdict "$python" - <<'E'
import json, math
out = json.load(open('out'))
rows = {r['name']: r for r in out['rows']}
assert {n: r['change'] for n, r in rows.items()} == {'same': 'none', 'slower': 'worse', 'faster': 'better', 'rate': 'worse', 'noisy': 'none',
                                                    'small': 'none', 'known': 'none'}, rows
assert abs(rows['rate']['times_worse'] - 1 / .8) < .04 and not out['measured_in_turn']
# Means of the logarithms 1/2 and 5/2, variances 1/2 and 9/2: t of 1.22 degrees of freedom by Welch, 2.5^2 / (.25^2 + 2.25^2).
# Its quantile at 95 % lies between those of 1 and 2 degrees, 12.706 and 4.303.
known = rows['known']
assert abs(math.log(known['times_worse']) - 2) < 1e-6
assert 4.303 < (math.log(known['upper']) - 2) / math.sqrt(2.5) < 12.706
E
expect in_turn_the_drift_cancels 1 "$ISOSHADE" bench compare a-drift.json b-drift.json
expect apart_it_does_not 0 "$ISOSHADE" bench compare a-drift.json c-drift.json
expect one_run_tells_nothing 1 "$ISOSHADE" bench compare once.json once.json
# A figure that is gone, that cannot be measured any more, and one of another command: each is listed with its cause.
"$python" - <<'E'
import json
def write(name, threads, rows):
    head = {'schema': 'isoshade.bench.all/1', 'session': name, 'machine': {'cores': 2}, 'threads': threads}
    head['headlines'] = [{'name': n, 'command': c, 'values': v, 'lower_is_better': True, **({'cause': why} if why else {})}
                         for n, c, v, why in rows]
    json.dump(head, open(name, 'w'))
usual = [1, 1.01]
write('had.json', 2, [('same', 'c', usual, ''), ('gone', 'c', usual, ''), ('fails', 'c', usual, ''), ('other', 'c', usual, ''),
                      ('wide', 'c', [1, 9], ''), ('never', 'c', [None, None], 'no Blender')])
write('has.json', 1, [('same', 'c', usual, ''), ('fails', 'c', [None, None], 'exit code 6'), ('other', 'c --more', usual, ''),
                      ('wide', 'c', [1, 9], ''), ('never', 'c', [None, None], 'no Blender here'), ('new', 'c', usual, '')])
E
expect figures_that_are_gone_are_exit_1 1 "$ISOSHADE" bench compare had.json has.json
check the_error_counts_them grep -q 'figures without a value in AFTER: 2' err
check other_threads_are_said grep -q 'measured apart, with other threads$' out
check an_interval_without_end_has_a_dash grep -Eq '^wide +1.000 +0.[0-9]+ to - *$' out
check each_is_listed_with_its_cause "$python" - <<'E'
import re
found = dict(re.findall(r'^(\w+) .* (gone|another command|not compared)\n', open('out').read(), re.M))
causes = dict(re.findall(r'^(\w+) .*\n +(.*)$', open('out').read(), re.M))
assert found == {'gone': 'gone', 'fails': 'gone', 'other': 'another command', 'never': 'not compared'}, found
assert causes == {'gone': 'missing in AFTER', 'fails': 'exit code 6', 'other': 'c --more', 'never': 'no Blender here'}, causes
E
expect in_the_answer_too 1 "$ISOSHADE" bench compare had.json has.json --json
check with_its_cause grep -q '"cause": "exit code 6"' out
# What is handed on to the commands and said of another program, and of what is left out.
printf '#!/bin/sh\necho "$*" >>"%s/asked"\nexit 6\n' "$dir" >failing && chmod +x failing
expect threads_are_for_all_commands 0 "$ISOSHADE" bench all --quick --repeat 1 --only build-memory --threads 1 --beside ./failing,other.json -o ours.json -q
check which_get_them grep -q '^bench build .* --threads=1$' asked
check and_the_answer_has_them grep -q '"threads": 1,' ours.json
check why_the_other_one_failed_is_said grep -q 'beside: failing: exit code 6' out
check in_its_own_answer_alone sh -c "grep -q '\"cause\": \"failing: exit code 6' other.json && ! grep -q cause ours.json"
check no_bar_for_small_sizes sh -c "! grep -q '<= 6' out"
refuse no_figures 4 'with figures' "$ISOSHADE" bench compare none.json a.json
refuse another_file 4 'schema' "$ISOSHADE" bench compare "$top/refscenes/shells.tf.json" a.json
refuse a_name_that_is_none 2 'no figure of that name' "$ISOSHADE" bench all --only nothing
refuse a_program_that_is_none 7 'no executable' "$ISOSHADE" bench all --only build-memory --quick --beside ./nothing,x.json
refuse beside_without_a_file 2 'PROGRAM,FILE.json' "$ISOSHADE" bench all --only build-memory --beside prog
exit $failed
