#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# doc/reference/glossary.md: each term of the field that help texts use has a row, and each row's term is used.
. "$(dirname "$0")/lib.sh"
glossary=$top/doc/reference/glossary.md

# Terms of the field that a newcomer cannot guess from plain English, as help texts have them (parts of words are enough).
terms="voxel|spacing|trilinear|transfer function|extinction|opacity|ray step|quadrature|isosurface|shading
|premultiplied|gradient|estimator|coherence|moments|agreement|direction code|hole|palette|level|pyramid
|joint histogram|small views|brick|mixed resolution|plan|slab|rank|scene|reference|renderer
|calibration|limit|atlas|front|RMSE|SSIM|FLIP|NRRD|NIfTI|OpenVDB|DF3|EXR"

commands=$("$ISOSHADE" --help | sed -n 's/^  \([a-z][a-z]*\)  .*/\1/p')
for command in $commands; do "$ISOSHADE" "$command" --help=all; done >help.txt 2>/dev/null
check help_texts_are_found test "$(wc -l <help.txt)" -gt 500

cat >glossary.py <<'PY'
import re
import sys

terms_of_help, glossary, *others = sys.argv[1:]
help_text = open("help.txt").read().lower()
rows = [l.split("|")[1].strip() for l in open(glossary) if l.startswith("|")]
rows = [r for r in rows if r not in ("term", "---")]
missing, unused = [], []
for term in re.split(r"\s*\|\s*", terms_of_help.strip()):
    in_help = re.sub(r"\s+", " ", help_text).find(term.lower()) >= 0
    if not in_help:
        unused.append(f"the list's \"{term}\" is in no help text")
    elif not any(term.lower() in r.lower() for r in rows):
        missing.append(f"\"{term}\" is in a help text, and has no row")
used = re.sub(r"[\s*`]+", " ", help_text + " ".join(open(o).read() for o in others)).lower()
for row in rows:  # one of a row's names is enough: the others are there for who knows them by those
    names = [n.strip() for n in re.split(r"[,()]", row) if n.strip()]
    if not any(n.lower() in used for n in names):
        unused.append(f"the glossary's \"{row}\" is used nowhere")
print("\n".join(missing + unused), end="")
PY
others=$(find "$top/doc" "$top/README.md" -name '*.md' ! -name glossary.md)
# shellcheck disable=SC2086 # a list of files
judge() { python3 glossary.py "$1" "$2" $others; }
nothing() { # NAME TEXT
    [ -z "$2" ] && ok "$1" || not_ok "$1" "$2"
}
nothing terms_of_help_texts_have_a_row_and_rows_are_used "$(judge "$terms" "$glossary")"
grep -v '^| coherence |' "$glossary" >fewer.md
check a_row_that_is_missing_is_found test "$(judge "$terms" fewer.md)" = '"coherence" is in a help text, and has no row'
sed 's/^| voxel |/| voxel | x |\n| frobnication |/' "$glossary" >more.md
check a_row_that_is_not_used_is_found test "$(judge "$terms" more.md)" = 'the glossary'\''s "frobnication" is used nowhere'
check a_term_that_help_does_not_have_is_found test "$(judge "voxel|frobnication" "$glossary")" = \
    'the list'\''s "frobnication" is in no help text'
exit $failed
