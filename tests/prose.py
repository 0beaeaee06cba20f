#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures how plainly comments, messages and pages are written, and holds them to budgets.

    prose.py [FOLDER]          each measure with its hits and its budget; ends with 1 if a budget is exceeded
    prose.py [FOLDER] MEASURE  the places of a measure, as file:line: text

A pattern's budget is in hits per 1,000 words of a kind of text: the highest rate of seven projects that are read easily
(meshoptimizer, lz4, OpenEXRCore, stb, OpenVDB, pbrt-v4, Mitsuba 3). The other measures have a number of hits, which may
only fall. A hit is a place to look at; a good sentence may hold one.
"""
import pathlib
import re
import sys

NOUN_FOR_WHAT = r"what (?:is|are|was|has|have|it|they|a|the|does|do|can|cannot|no|others?|makes?|shows?|follows|came|comes|such|that|each)"
# name: expression, kinds of text (c: comments, m: messages, d: pages), hits per 1,000 words
PATTERNS = {
    "what for a noun": (rf"\b{NOUN_FOR_WHAT}\b", "cmd", 0.3),
    "label with What": (r"\AWhat [^?]*\Z", "c", 0.05),
    "fragment": (r"\A(?:Of|By|With|Without|From|Among|Until|Beside|Behind) [^.:;]*\.", "c", 0.2),
    "where for if": (r"\bwhere (?:it|there|they|that|this|he|one|no|nothing|not|memory|both|none)\b", "cmd", 0.5),
    "said or told": (r"\b(?:is|are|was|were|be|been) (?:said|told)\b|\btells? (?:of|that|how|what|which|where)\b|\b(?:said|told) by\b", "cmd", 0.2),
    "behind, beside": (r"\b(?:behind|beside)\b", "cmd", 0.1),
    "is no": (r"\b(?:is|are|was|were|be) no (?!longer\b|more\b|less\b|better\b|nearer\b|worse\b|larger\b|need\b|way\b)\w+", "cmd", 0.5),
    "so many": (r"\bso (?:many|much|few) (?!that\b|as\b)\w+", "cmd", 0.05),
    "old word": (r"\b(?:whatever|likewise|anew|alike|thereof|be it|be they|had it been|foresees?|foreseen|nought)\b", "cmd", 0.3),
    "a for per": (r"\b(?:an?|one|two|three|four|\d+) (?:byte|float|line|file|row|level|picture|start|number|process|value|entry|word|color|bit|index|grid|function)s? an? [a-z]+\b", "cmd", 0.05),
    "question": (r"\A(?:Is|Does|Do|Has|Have|Are|Can|Did|May|Was|Will)\b[^.]*\?", "c", 0.1),
    "private word": (r"\b(?:rooms?|strangers?|keepers?|baton|witness|arbiter|the house|the truth)\b", "cmd", 0.02),
    "comma, else": (r"; else\b|, else (?:NULL|0|the|it|a)\b", "cmd", 0.1),
}
CLAUSE = re.compile(r"\b(?:that|which|what|who|whose|where|whom|whatever)\b", re.I)
CLAUSES, CLAUSES_RATE = 3, 0.25  # relative clauses in a sentence
SENTENCE_WORDS = 35
COLUMNS = 120
# Numbers of places; each may only fall.
MOST = {"long sentence": 0, "long line of C": 126, "long line of a script": 824, "detached comment": 0}
KINDS = {"c": "comments", "m": "messages", "d": "pages"}
SOURCES = (".c", ".h", ".cc", ".inc", ".glsl", ".vert", ".frag")


def sources(root, folders, endings):
    for folder in folders:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in endings and "build" not in path.relative_to(root).parts and path.is_file():
                yield path


def pages(root):
    yield from sorted(root.glob("*.md"))
    yield from sorted((root / "doc").rglob("*.md"))


def line_of(text, at):
    return text.count("\n", 0, at) + 1


ROW = "¦" # before an indented line of a comment: a row of a list
COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|(/\*.*?\*/|//[^\n]*)', re.S)


def comments(text):
    """(offset, words) of each comment of more than two words; markers are left out."""
    for found in COMMENT.finditer(text):
        if found.group(1):
            body = re.sub(r"^/[/*]+|\*/$", "", found.group(1))
            body = re.sub(r"\n\s*\*?", "\n", body)
            body = " ".join(re.sub(r"\n\s*\n|\n {3,}", f" {ROW} ", body).split())
            if len(body.split()) > 2 and "SPDX" not in body and "clang-format" not in body:
                yield found.start(), body


def messages(text):
    """(offset, words) of each text of at least six words and 30 characters; neighbors are one."""
    blank = COMMENT.sub(lambda m: re.sub(r"[^\n]", " ", m.group(0)) if m.group(1) else m.group(0), text)
    for found in re.finditer(r'"(?:\\.|[^"\\\n])*"(?:\s*"(?:\\.|[^"\\\n])*")*', blank):
        body = re.sub(r'"\s*"', "", found.group(0)).strip('"')
        if len(body) > 30 and body.count(" ") > 4:
            yield found.start(), body


def paragraphs(text):
    """(offset, words) of each paragraph that is neither code nor a table."""
    text = re.sub(r"```.*?```", lambda m: re.sub(r"[^\n]", " ", m.group(0)), text, flags=re.S)
    for found in re.finditer(r"(?:^(?!    ).*\S.*\n?)+", text, re.M):
        yield found.start(), " ".join(found.group(0).split())


def texts(root):
    """(kind, file, line, words) of all comments, messages and paragraphs."""
    for path in sources(root, ("src", "exporters"), SOURCES):
        text = path.read_text(errors="replace")
        for kind, parts in (("c", comments(text)), ("m", messages(text))):
            for at, body in parts:
                yield kind, path.relative_to(root), line_of(text, at), body
    for path in pages(root):
        text = path.read_text()
        for at, body in paragraphs(text):
            yield "d", path.relative_to(root), line_of(text, at), body


def sentences(body):
    return re.split(rf"(?<=[.;:?!])\s+|\s*{ROW}\s*", body)


def is_long(kind, sentence):
    """True if a sentence of prose is too long: no drawing, table, format or list of names."""
    return (len(sentence.split()) > SENTENCE_WORDS and "|" not in sentence and "\\n" not in sentence and
            not re.search(r"  |[=<>{}\[\]]|%[sdzg]|`[^`]*`.*`[^`]*`.*`", sentence))


def long_lines(root, endings):
    for path in sources(root, ("src", "exporters", "tests"), endings):
        for number, line in enumerate(path.read_text(errors="replace").split("\n"), 1):
            if len(line) > COLUMNS and '"' not in line and "http" not in line:
                yield path.relative_to(root), number, line.strip()


DETACHED = re.compile(r"^/\* (?!----|clang-format)(?:(?!\*/).)+\*/\n\n(?=[a-z])", re.M | re.S)


def detached_comments(root):
    """Comments of one sentence or more at the margin, after the head of a file, with an empty line between them and the code."""
    for path in sources(root, ("src", "exporters"), (".c", ".h", ".cc")):
        text = path.read_text(errors="replace")
        for found in DETACHED.finditer(text):
            if line_of(text, found.start()) > 3:
                yield path.relative_to(root), line_of(text, found.start()), " ".join(found.group(0).split())


def measure(root):
    """Yields (name, kind, [(file, line, text)], budget in places, words)."""
    all_texts = list(texts(root))
    words = {k: max(1, sum(len(t[3].split()) for t in all_texts if t[0] == k)) for k in KINDS}
    for name, (expression, kinds, rate) in PATTERNS.items():
        pattern = re.compile(expression, 0 if expression.startswith(r"\A") else re.I)
        for kind in kinds:
            hits = [t[1:] for t in all_texts if t[0] == kind for _ in pattern.finditer(t[3])]
            yield name, KINDS[kind], hits, rate * words[kind] / 1000
    for kind in KINDS:
        hits = [t[1:3] + (s,) for t in all_texts if t[0] == kind for s in sentences(t[3]) if len(CLAUSE.findall(s)) >= CLAUSES]
        yield "three clauses", KINDS[kind], hits, CLAUSES_RATE * words[kind] / 1000
    yield ("long sentence", "all", [t[1:3] + (s,) for t in all_texts for s in sentences(t[3]) if is_long(t[0], s)],
           MOST["long sentence"])
    for name, endings in (("long line of C", SOURCES), ("long line of a script", (".py", ".js", ".sh"))):
        yield name, "code", list(long_lines(root, endings)), MOST[name]
    yield "detached comment", "code", list(detached_comments(root)), MOST["detached comment"]


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    wanted = sys.argv[2] if len(sys.argv) > 2 else None
    exceeded = 0
    for name, kind, hits, budget in measure(root):
        if wanted == name:
            for path, line, text in hits:
                print(f"{path}:{line}: {text[:200]}")
        elif not wanted:
            over = len(hits) > budget
            exceeded += over
            print(f"{name:22s} {kind:9s} {len(hits):5d} of at most {budget:.0f}{'   exceeded' if over else ''}")
    return exceeded > 0


if __name__ == "__main__":
    sys.exit(main())
