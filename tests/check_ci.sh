#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The recipes of doc/guide/ci, run by an imitation of each service's runner (ci_runner.py): a right renderer passes, a
# planted fault fails and is named, and so does a repository without an accepted report. The package is not installed:
# isoshade is in the PATH, and apt-get is a program that looks whether its files are there.
. "$(dirname "$0")/lib.sh"
python_with numpy,yaml
"$python" -c 'import numpy, yaml' 2>/dev/null || { skip recipes_of_ci "no python3-numpy or no python3-yaml"; exit 0; }
mkdir bin && ln -s "$ISOSHADE" bin/isoshade && ln -s "$(command -v "$python")" bin/python3
cat >bin/apt-get <<'SH'
#!/bin/sh
for word; do
    case $word in ./*) [ -f "$word" ] || { echo "E: Unsupported file $word given on commandline" >&2; exit 100; } ;; esac
done
SH
chmod +x bin/apt-get
export PATH=$dir/bin:$PATH
ci() { python3 "$top/tests/ci_runner.py" "$top/doc/guide/ci/$1.yml" "$2"; }
repository() { # NAME: a checkout with a renderer
    mkdir -p "$1/ci" && cp "$top"/doc/guide/{numpy_renderer.py,renderers.json} "$1" &&
        touch "$1/ci/isoshade_1_amd64.deb"
}
wrong() { # NAME: as repository, with half the extinction
    repository "$1" && sed -i 's/-np.expm1(-sigma/-np.expm1(-0.5 * sigma/' "$1/numpy_renderer.py"
}

repository first
expect without_an_accepted_report_it_fails 3 ci github first
check and_names_it grep -q 'ci/accepted' err
accept() { cp -r first/report "$1/ci/accepted"; }
repository right && accept right
expect github_passes_a_right_renderer 0 ci github right
check with_the_verdict_on_the_page grep -q '^The renderers agree' right.summary
check and_no_difference grep -q '^No difference in ' right.summary
check and_a_link_to_the_pictures grep -q '^\[Reports with pictures\](https://' right.summary
wrong bad && accept bad
expect github_fails_a_wrong_one 9 ci github bad
check its_page_names_the_mistake grep -q 'extinction were half' bad.summary
check and_the_verdict_that_changed grep -q '| pass | fail |' bad.summary

repository calm && accept calm
expect gitlab_passes_a_right_renderer 0 ci gitlab calm
check with_its_tests grep -q '<testcase classname="calibration.numpy".* name="slab"/>' calm/results.xml
wrong worse && accept worse
expect gitlab_fails_a_wrong_one 1 ci gitlab worse
check its_tests_name_the_mistake grep -q 'extinction were half' worse/results.xml
rm right/ci/*.deb
expect a_package_that_is_missing_fails 100 ci github right
exit $failed
