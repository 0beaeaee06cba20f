#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the pages of doc/reference that are made from the program: reference_pages.py ISOSHADE TOP FOLDER

FOLDER/names.md, commands.md (from --help) and library.md (from src/isoshade.h). `make reference` writes them into
doc/reference, and check_names.sh compares them.
"""
import pathlib
import re
import subprocess
import sys
import textwrap

OPTION = re.compile(r"^  (?:(-\w), |    )(--[\w-]+(?:[= ]\S+)?)(?:\s{2,}(\S.*))?$")

# Ends the part of a comment that the page has: a sentence, or its main clause.
EVERYWHERE = ("--json", "--quiet", "--help", "--threads", "--timeout", "--no-sandbox", "--full-paths", "--no-provenance")
END = re.compile(r"\. (?=[A-Z])| \(|[:;] |, (?:which|so|and r|as|or|applying|x f|whose|to be)\b")


def printed(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def sections(text):
    """The paragraphs of a help text that begin with "NAME:", by name, and the lines before them."""
    found, name = {"": []}, ""
    for line in text.splitlines():
        heading = re.match(r"^(usage|options|commands|examples|benchmarks|more options): ?(.*)$", line)
        if heading:
            name = heading.group(1)
            found[name] = [heading.group(2)] if heading.group(2) else []
        elif re.match(r"^\S", line) and name != "":
            name = "other"
            found.setdefault(name, [])
        else:
            found[name].append(line)
    return found


def options(lines):
    """(name with argument, effect) of each option; lines that continue an effect are joined."""
    rows = []
    for line in lines:
        option = OPTION.match(line)
        if option:
            short, name, effect = option.groups()
            rows.append([f"`{short}`, `{name}`" if short else f"`{name}`", effect or ""])
        elif line.startswith("    ") and rows:
            rows[-1][1] = f"{rows[-1][1]} {line.strip()}".strip()
    return [tuple(row) for row in rows]


def bullets(rows, out):
    out += [f"- {name}: {effect}" for name, effect in rows] + [""]


def commands_page(program):
    listed = [re.match(r"^  ([a-z]+)  +(.*)$", l) for l in sections(printed(program, "--help"))["commands"]]
    parts = {m.group(1): sections(printed(program, m.group(1), "--help")) for m in listed if m}
    of_command = {name: options(part.get("options", [])) for name, part in parts.items()}
    count = {}
    for rows in of_command.values():
        for row in rows:
            count[row] = count.get(row, 0) + 1
    shared = [row for row in count if count[row] >= 3]
    out = ["# Commands", "", "Made by `make reference` from `isoshade COMMAND --help`. `isoshade COMMAND --help=all` explains rarer "
           "options,", "and each help text ends with examples. [Names](names.md) lists the values of options.", "",
           "## Shared options", "", "These options have the same effect in all commands that have them. Lists of commands leave out those",
           "of running and output.", ""]
    bullets(sorted(shared, key=lambda row: row[0].lstrip("`-")), out)
    for name, summary in (m.groups() for m in listed if m):
        usage = " ".join(" ".join(parts[name]["usage"]).split())
        out += [f"## {name}", "", summary[0].upper() + summary[1:] + ("" if summary[-1] in ".?" else "."), "", "```text", usage, "```", ""]
        own = [row for row in of_command[name] if row not in shared]
        if own:
            bullets(own, out)
        words = [re.search(r"--[\w-]+", row[0]).group(0) for row in of_command[name] if row in shared]
        if words:
            out += ["Shared: " + " ".join(f"`{word}`" for word in words if word not in EVERYWHERE) + ".", ""]
    return "\n".join(out).replace("Shared: .\n\n", "")


def library_page(header):
    text = header.read_text()
    out = ["# Library", "", "Made by `make reference` from [isoshade.h](../../src/isoshade.h), which has the full contracts.",
           "Link with `pkg-config --cflags --libs isoshade`. The header is C99 and C++.", ""]
    for name, body in re.findall(r"/\* ---- (\w[\w ]*?) -+ \*/\n(.*?)(?=/\* ---- |#ifdef __cplusplus\n\})", text, re.S):
        rows = []
        for comment, code in re.findall(r"(?:/\*((?:(?!\*/).)*)\*/\n)?((?:const )?\w+ \**iso_\w+\([^;]*\));", body, re.S):
            sentence = re.sub(r"\s*\n \* ?", " ", comment).strip()
            sentence = END.split(sentence)[0].removesuffix(".")
            rows.append((re.search(r"iso_\w+(?=\()", code).group(0), sentence.replace("*", "\\*")))
        if rows:
            out += [f"## {name.capitalize()}", ""] + [f"- `{f}()`: {s}".removesuffix(": ") for f, s in rows] + [""]
    return "\n".join(out)


def write(name, text):
    """Writes a page, its lists wrapped at 120 columns."""
    lines = [textwrap.fill(l, 120, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False) if l.startswith("- ") else l
             for l in text.rstrip().split("\n")]
    (folder / name).write_text("\n".join(lines) + "\n")


def names_page(program):
    """Returns the lists of `isoshade list`. Formats have pages of their own, with more columns."""
    head, *lists = re.split(r"(?m)^(?=## )", printed(program, "list", "--markdown"))
    pages = {"volume formats": "formats-read", "transfer-function formats": "tf-formats"}
    title_of = lambda one: one.split("\n", 1)[0][3:]
    if missing := pages.keys() - map(title_of, lists):
        sys.exit(f"isoshade list has no {', '.join(missing)}")
    links = ", ".join(f"[{title}]({page}.md)" for title, page in pages.items())
    return head + f"On other pages: {links}.\n\n" + "".join(one for one in lists if title_of(one) not in pages)


program, top, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
write("names.md", names_page(program))
write("commands.md", commands_page(program))
write("library.md", library_page(top / "src/isoshade.h"))
