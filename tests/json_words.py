# SPDX-License-Identifier: MIT
"""The words that the program's JSON files hold, taken from its code: json_words.py FOLDER...

One a line: each short text in lower case inside a call of jansson that makes an object, of the JSON readers, and of the lists
of keys that readers accept.
"""
import pathlib
import re
import sys

MAKES = r'(?:json_(?:pack|object_set(?:_new)?|object_update_new|string)|iso_json_get_\w+|\bput\b|keys\[\] =|words\[\] =)'
TEXT = re.compile(r'"([a-z][a-z0-9_]*)"')

# Files for other programs; doc/reference/tf-formats.md names their keys where they matter.
OTHERS = {"format_slicer.c", "format_paraview.c", "format_niivue.c", "target_paraview.c"}

words = {}
for folder in sys.argv[1:]:
    for path in sorted(pathlib.Path(folder).rglob("*.c")):
        if path.name in OTHERS:
            continue
        text = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S)
        for statement in re.split(r"[;]", text):
            if re.search(MAKES, statement) and ("json" in statement or "keys" in statement):
                found = re.search(MAKES, statement)
                for word in TEXT.findall(statement[found.start():]):
                    words.setdefault(word, path.name)
for word in sorted(words):
    print(word, words[word])
