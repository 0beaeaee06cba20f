#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The mutants of `make mutants` fit the code as it stands; a stale one would plant nothing.
. "$(dirname "$0")/lib.sh"
check mutants_fit_the_code bash "$top/tests/mutants.sh" --check
mkdir -p copy/tests && cp "$top/tests/mutants.sh" "$top/tests/environment.sh" copy/tests/ && cp -r "$top/src" copy/
{ sed -n '/^tests: /p' "$top/tests/mutants.txt"; printf '= stale\nfile: src/compare/metrics.c\nold: this stands nowhere\nnew: nothing\n'; } >copy/tests/mutants.txt
notice one_whose_text_is_gone bash copy/tests/mutants.sh --check
{ printf '= twice\nfile: src/compare/metrics.c\nold: return\nnew: else\n'; } >copy/tests/mutants.txt
notice one_whose_text_stands_often bash copy/tests/mutants.sh --check
exit $failed
