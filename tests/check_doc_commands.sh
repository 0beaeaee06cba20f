#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Commands on the pages of doc/: each option of each one is an option of its command, and each runs, on a small volume in
# place of those that the pages name and with few pixels and repetitions. README.md and the blocks of the guide are run as
# they stand, by check_readme.sh. Pages can be named as arguments: doc/guide/blender.md ...
. "$(dirname "$0")/lib.sh"
isoshade() { "$ISOSHADE" "$@"; }
isoshade-lab() { "$LAB" "$@"; }
export -f isoshade isoshade-lab

cat >commands.py <<'END'
# With a page as argument: a line for each command on it: number <TAB> "run", "options" or a reason not to run it <TAB> the
# command as it is checked.
import re, sys

page = sys.argv[1]

# Words that stand for something, and volumes that a reader has and this test does not; all are the same small volume.
STANDS_FOR = [
    (r"(VOLUME|[a-z0-9_/]*(ch2|ch2bet)\.nii\.gz)\b", "v.nrrd"),
    (r"\b(nucleon_41|fuel_crop|aneurism_256|bonsai_256|engine_256x256x128|cranium_ct_hu|mr_seg3d|heptane_302|inia19_t1_float|engine|big|head)\.nrrd", "v.nrrd"),
    (r"v\.nrrd\.\.\.|v\.nrrd,\.\.\.", "v.nrrd"),
    (r"\b(SCENE|s|head)\.scene\.json|(?<=--scene )S\b", "refscenes/shells.scene.json"),
    (r"(?<=--step )S\b", "0.5"),
    (r"\b(FOLDER|DIR|FILE)\b", "folder"),
    (r" \.\.\.$", ""),
    (r"v\.nrrd v\.nrrd( v\.nrrd)+", "v.nrrd v.nrrd"),  # several are two
    (r"v\.nrrd,v\.nrrd(,v\.nrrd)+", "v.nrrd,v.nrrd"),
    (r"(isoshade-lab palette) v\.nrrd v\.nrrd", r"\1 v.nrrd"),
]

# The last of an option that is given twice counts: what makes a command small, by its first words.
SMALL = [
    ("make", "--size 32x36x28"),
    ("render .*--roi", "--size 12 --level 1 --roi 2,3,4,9,12,14"),
    ("render", "--size 12"),
    ("export .*--to (blender|povray)", "--size 12"),
    ("build .*--for ", "--effort fast"),
    ("plan", "--size 12"),
    ("chart", "--size 12 --levels 1 --steps 1 --codes fit --filters moments --estimators central --with gl --plans none --budget 0 --want 1"),
    ("validate", "--size 8 --quick --with gl --levels 2"),
    ("palette", "--entries 16"),
    ("atlas", "--case code-poles"),
    ("figure .*--kind grid", "--dpi 40 --with reference,gl"),
    ("figure", "--dpi 40"),
    ("bench all", "--quick --repeat 1 --only build-memory"),
    ("bench build", "--size 24 --levels 2 --runs 1"),
    ("isoshade-lab encode", "--count 200 --size 12"),
    ("isoshade-lab gradient", "--size 32"),
    ("isoshade-lab palette", "--steps 4 --seeds 1 --entries 60"),
    ("isoshade-lab fit", "--levels 2"),
    ("isoshade-lab plan", "--size 16 --cycles 8"),
    ("isoshade-lab seams", "--layouts 2"),
    ("isoshade-lab ghosts", "--levels 2"),
    ("isoshade-lab tf", "--size 24 --runs 1"),
    ("isoshade-lab reference", "--size 6"),
    ("bench scale", "--largest 64"),
    ("bench render", "--image 16 --runs 1 --size 32"),
    ("isoshade-lab convergence", "--steps 2 --size 8"),
    ("isoshade-lab bound", "--size 16 --views 1 --levels 2"),
    ("isoshade-lab levels", "--size 16 --views 1 --levels 2 --methods default --tfs soft"),
    ("isoshade-lab consistency .*--analytic", "--analytic 16 --size 16 --views 1 --level 1"),
    ("isoshade-lab consistency", "--size 16 --views 1 --level 1 --with gl"),
]

# What is not run, with the reason; its options are checked like those of the others.
NOT_RUN = [
    (r"bench (compare|all .*--beside) ", "files and a program of another day; tests/check_bench_all.sh has some"),
    (r"validate .*--images", "its pictures come from a renderer elsewhere; tests/check_images.sh has some drawn"),
    (r"validate .*--blender ", "it needs a second Blender; tests/check_blenders.sh compares one with itself"),
    (r"render .*--gl-device 1", "it needs a second device; tests/check_gl_device.sh asks for those that are there"),
    (r"make shells --size 512", "a volume of 512 voxels a side: minutes beside other work, and a gigabyte"),
    (r"validate --suite", "a minute; tests/check_suite_all.sh runs all scenes of the suite"),
    (r"isoshade-lab consistency --(shading|filters)", "minutes; tests/lab/check_consistency.sh runs them with few voxels and pixels"),
    (r"isoshade-lab encode", "a minute whatever the options; tests/lab/check_encode.sh runs it"),
    (r"isoshade-lab power", "minutes: it renders random scenes until each limit has been tried; tests/lab/check_power.sh runs it"),
    (r"render ml\.nrrd .*report/images", "an excerpt of a report; tests/check_suite.sh runs such lines of its own reports"),
    (r"render v\.iso .*flipped", "an excerpt: it needs a build with the code flipped; tests/test_flipped_fetch.c has the fetch"),
]

def joined(lines):
    """Numbered lines, with continuations joined."""
    whole, first = "", 0
    for number, line in lines:
        first = first if whole else number
        whole += line.strip() if whole else line.rstrip()
        if whole.endswith("\\"):
            whole = whole[:-1].rstrip() + " "
            continue
        yield first, whole
        whole = ""

text = open(page).read().split("\n")
fence = None
commands = []
blocks = []
for number, line in enumerate(text, 1):
    mark = re.match(r"```(\w*)", line)
    if mark:
        fence = None if fence is not None else mark.group(1)
    elif fence == "sh" or (fence is None and line.startswith("    ")):
        blocks.append((number, line.strip() if fence == "sh" else line[4:]))
for number, line in joined(blocks):
    if re.match(r"isoshade(-lab)? |make ", line):
        commands.append((number, "run", re.split(r"\s{3,}", line)[0]))
for number, line in enumerate(text, 1):
    if not line.startswith("    "):
        if line.count("`") % 2: # a command that goes on in the next line
            line += " " + "".join(text[number:number + 1]).strip()
        commands += [(number, "options", m) for m in re.findall(r"`(isoshade(?:-lab)? [a-z]+ [^`]*--[^`]*)`", line)]

for number, kind, line in commands:
    if line.startswith("make "):
        print(number, "a target of the Makefile", line, sep="\t")
        continue
    words = line.removeprefix("isoshade ")
    if kind == "run":
        kind = "options" if "/doc/guide/" in page else next((why for pattern, why in NOT_RUN if re.match(pattern, words)), "run")
    for pattern, replacement in STANDS_FOR:
        line = re.sub(pattern, replacement, line)
    if kind == "run":
        first, *rest = line.split(" && ")
        small = next((more for pattern, more in SMALL if re.match(pattern, first.removeprefix("isoshade "))), "")
        line = " && ".join([f"{first} {small}".rstrip(), *rest])
    print(number, kind, line, sep="\t")
END

# With --help a command says what is wrong with its options, and does nothing.
options_are_known() { eval "${1%% && *} --help" >/dev/null </dev/null; }
check a_known_option_is_known options_are_known 'isoshade render v.nrrd --size 3'
notice an_unknown_option_is_noticed options_are_known 'isoshade render v.nrrd --sizes 3'

# A page has its own folder, in which its commands run in their order.
run_page() { # page
    local page=$1 name=${1#"$top/"} number kind line output count=0 bad=0
    mkdir -p "$dir/$name/folder" "$dir/$name/doc/figures" && cd "$dir/$name" || return
    ln -s "$top/refscenes" refscenes
    cp "$dir/v.nrrd" . && cp -r "$dir/v.iso" . && cp "$dir/palette.csv" .
    while IFS=$'\t' read -r number kind line; do
        count=$((count + 1))
        if [[ $line == isoshade* ]]; then
            output=$(options_are_known "$line" 2>&1) || { not_ok "$name:$number" "$line: $(tail -n 1 <<<"$output")"; bad=1; continue; }
        fi
        case $kind in
            options) ;;
            run)
                if output=$(bash -c "$line" 2>&1 </dev/null); then :
                elif [[ $output == *cycles.exr* ]] && ! has_cycles; then skip "$name:$number" "the picture before was not drawn: $lack"
                else not_ok "$name:$number" "$line: $(tail -n 2 <<<"$output")"; bad=1; fi ;;
            *) echo "# not run, $name:$number: $line: $kind" ;;
        esac
    done < <(python3 "$dir/commands.py" "$page")
    total=$((total + count))
    [ $bad = 1 ] || [ $count = 0 ] || ok "$name: $count commands"
}
isoshade make shells --size 24x28x20 --spacing 1x1x1.5 -o v.nrrd -q
isoshade build v.nrrd -o v.iso --keep-magnitude --keep-float -q >/dev/null
isoshade palette v.nrrd -o palette.csv --entries 16 -q >/dev/null

mkdir planted
printf 'Words.\n\n    isoshade info nothing.nrrd\n' >planted/fails.md
printf 'Words, `isoshade make --sizes 3`.\n' >planted/option.md
printf 'Words, `isoshade make\n--sizes 3`, and more.\n' >planted/broken.md
total=0
for page in fails option broken; do
    check "a_page_that_${page}_would_be_seen" grep -q '^not ok' <(run_page "$dir/planted/$page.md")
done
total=0
if [ $# -gt 0 ]; then
    for page; do run_page "$top/$page"; done
else
    for page in "$top"/doc/*.md "$top"/doc/*/*.md; do run_page "$page"; done
    check the_pages_have_commands test $total -ge 60
fi
exit $failed
