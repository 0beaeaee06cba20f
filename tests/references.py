#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lists what comments and pages refer to and what is not there; check_references.sh runs it. usage: references.py FOLDER

- a key such as [wang-2004] that doc/reference/references.md does not list, and a key there that nothing cites;
- a paper that is cited by names and a year instead of its key;
- a file name in a comment or a page that no file ends with, and a function iso_...() that no code has.

Files that are written at run time begin with a word in capitals (NAME.gp, DIR/index.html) or stand in `written`.
"""
import pathlib
import re
import sys

top = pathlib.Path(sys.argv[1])
rooms = ("src", "exporters", "tests", "doc", "refscenes")
# What commands on pages write; n.h: a dot product; a library's name; the last are of other projects.
written = {"index.html", "today.html", "planned.html", "levels.py", "shells-paraview.py", "summary.md", "difference.md", "brain.html", "ml.html", "mine.html", "n.h", "vtk.js", "numpy.py", "xxhash_spec.md", "NanoVDB.h", "NanoToOpenVDB.h"}
examples = ("doc/extending.md", "tests/fifth_renderer.c")  # whose files are the reader's
suffix = r"(?:h|c|cc|py|md|sh|glsl|gp|js|css|html)"
file_name = re.compile(r"(?<![\w./$*{}<>%-])([A-Za-z0-9_][\w.-]*(?:/[\w.-]+)*\." + suffix + r")\b(?![/.(-]*\w)")
function = re.compile(r"\b(iso_[a-z0-9_]+)\(\)")
key = re.compile(r"\[((?:[a-z]+-)+(?:19|20)\d\d)\]")
by_name = re.compile(r"\b[A-Z][a-z]+,?(?: et al\.| and [A-Z][a-z]+)?,? \(?(?:19[5-9]|20[012])\d\b(?!-)")
months = re.compile(r"\b(?:January|February|March|April|May|June|July|August|September|October|November|December|"
                    r"Copyright|Version|Blender|Debian)\b")


def texts(path, text):
    """Comments of code with their offsets; the whole of a page."""
    kind = path.suffix
    if kind in (".c", ".h", ".cc", ".glsl", ".js", ".css"):
        pattern = r"/\*.*?\*/|(?<![:\"'])//[^\n]*"
    elif kind in (".sh", ".py", ".gp"):
        pattern = r"(?<![^\n\s])#(?!!) [^\n]*|\"\"\".*?\"\"\""
    elif kind == ".md":
        pattern = r".+"
    else:
        return
    for match in re.finditer(pattern, text, re.S):
        yield match.start(), match.group(0)


def is_written(name):
    return name.split("/")[-1] in written or re.match(r"[A-Z]{2,}", name.split("/")[0]) or re.search(r"\b[A-Z]{3,}(?![a-z])|_[A-Z]{2,}\b", name)


files = [p for room in rooms for p in (top / room).rglob("*") if p.is_file() and "__pycache__" not in p.parts]
files += [p for p in top.glob("*.md")]
endings, code, cited, found = set(), set(), set(), []
contents = {}
for path in sorted(files):
    parts = path.relative_to(top).parts
    endings |= {"/".join(parts[i:]) for i in range(len(parts))} | {parts[-1]}
    if path.suffix in (".svg", ".png", ".nrrd", ".pdf") or path.name in ("references.py", "check_references.sh"):
        continue
    try:
        contents[path] = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        continue
    if path.suffix in (".c", ".h", ".cc"):
        code |= set(re.findall(r"\biso_[a-z0-9_]+", re.sub(r"/\*.*?\*/", "", contents[path], flags=re.S)))
listing = top / "doc/reference/references.md"
listed = set(key.findall(contents.get(listing, "")))
for path, text in contents.items():
    if path == listing:
        continue
    name = path.relative_to(top).as_posix()

    def line(offset):
        return f"{name}:{text.count(chr(10), 0, offset) + 1}"

    for match in key.finditer(text):
        cited.add(match.group(1))
        if match.group(1) not in listed:
            found.append(f"{line(match.start())}: key {match.group(1)} is not in doc/reference/references.md")
    for start, comment in texts(path, text):
        for match in file_name.finditer(comment) if name not in examples else ():
            last = match.group(1).split("/")[-1]
            base = path.parent / match.group(1) if path.suffix == ".md" else None
            if match.group(1) not in endings and not is_written(match.group(1)) and not (base and base.exists()):
                if "/" not in match.group(1) or last not in endings:
                    found.append(f"{line(start + match.start())}: no file {match.group(1)}")
        for match in function.finditer(comment):
            if match.group(1) not in code:
                found.append(f"{line(start + match.start())}: no function {match.group(1)}()")
        for match in by_name.finditer(comment):
            if not months.search(match.group(0)):
                found.append(f"{line(start + match.start())}: \"{match.group(0)}\" has a key in doc/reference/references.md, or should")
found += [f"doc/reference/references.md: nothing cites {k}" for k in sorted(listed - cited)]
print("\n".join(found))
