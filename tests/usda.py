# SPDX-License-Identifier: MIT
"""Reads a .usda by a grammar of its own, strictly, and prints what it says: usda.py FILE.

The part of the format that is written here: metadata, prims with a type and a name, attributes and relationships. What the
schema UsdVol asks of a Volume and of OpenVDBAssets is checked; anything else ends with exit code 1.
"""
import os
import re
import sys

TOKEN = re.compile(r'\s*(?:(@@@.*?@@@|@[^@\n]*@)|("[^"\n]*")|(<[^>\n]*>)|([A-Za-z_][\w:]*(?:\[\])?)|(-?\d[\d.eE+-]*)|([(){}\[\]=,]))')
TYPES = {"asset", "token", "int", "float3[]"}
CLASSES = {"levelSet", "fogVolume", "staggered", "unknown"}


def fail(why):
    sys.exit(f"usda: {why}")


class Reader:
    def __init__(self, text):
        self.text, self.at = text, 0

    def next(self, wanted=None):
        match = TOKEN.match(self.text, self.at)
        if not match:
            if self.text[self.at:].strip():
                fail(f"cannot read {self.text[self.at:].strip()[:30]!r}")
            return None
        token = match.group().strip()
        if wanted and token != wanted:
            fail(f"{token!r} where {wanted!r} is due")
        self.at = match.end()
        return token

    def peek(self):
        at = self.at
        token = self.next()
        self.at = at
        return token

    def value(self):
        token = self.next()
        if token not in ("(", "["):
            return token
        close, items = {"(": ")", "[": "]"}[token], []
        while self.peek() != close:
            items.append(self.value())
            if self.peek() != close:
                self.next(",")
        self.next(close)
        return items

    def metadata(self):
        found = {}
        self.next("(")
        while self.peek() != ")":
            key = self.next()
            self.next("=")
            found[key] = self.value()
        self.next(")")
        return found

    def prim(self):
        prim = {"type": self.next(), "name": self.next(), "attributes": {}, "rels": {}, "prims": []}
        if not re.fullmatch(r'"[A-Za-z_]\w*"', prim["name"]):
            fail(f"{prim['name']} is no name of a prim")
        prim["name"] = prim["name"].strip('"')
        self.next("{")
        while self.peek() != "}":
            kind = self.next()
            if kind == "def":
                prim["prims"].append(self.prim())
                continue
            if kind != "rel" and kind not in TYPES:
                fail(f"an attribute of type {kind}")
            name = self.next()
            self.next("=")
            prim["rels" if kind == "rel" else "attributes"][name] = self.value()
        self.next("}")
        return prim


path = sys.argv[1]
text = open(path, encoding="utf-8").read()
text = re.sub(r"(?m)(?<=\n)#.*$", "", text)  # comments; the first line is none
if not text.startswith("#usda 1.0\n"):
    fail("the first line is not #usda 1.0")
reader = Reader(text[len("#usda 1.0\n"):])
layer = reader.metadata()
reader.next("def")
volume = reader.prim()
if reader.next():
    fail("something follows the Volume")
if volume["type"] != "Volume" or layer["defaultPrim"] != f'"{volume["name"]}"':
    fail("the default prim is not the Volume")
if layer["upAxis"] not in ('"Y"', '"Z"') or not float(layer["metersPerUnit"]) > 0:
    fail("upAxis or metersPerUnit is wrong")
extent = [[float(v) for v in corner] for corner in volume["attributes"]["extent"]]
if len(extent) != 2 or not all(a < b for a, b in zip(*extent)):
    fail(f"the extent is {extent}")
assets = {p["name"]: p["attributes"] for p in volume["prims"] if p["type"] == "OpenVDBAsset"}
if len(assets) != len(volume["prims"]) or len(assets) != len(volume["rels"]):
    fail("prims and relationships are not one to one")
for rel, target in volume["rels"].items():
    name = target.strip("<>").rsplit("/", 1)[-1]
    if not rel.startswith("field:") or target != f"</{volume['name']}/{name}>" or name not in assets:
        fail(f"{rel} leads to {target}")
print("unit", layer["metersPerUnit"], "up", layer["upAxis"].strip('"'), "extent", extent)
for name, asset in assets.items():
    file = asset["filePath"].strip("@")
    if os.path.isabs(file) or not os.path.exists(os.path.join(os.path.dirname(path) or ".", file)):
        fail(f"{file} is not beside it")
    if asset["fieldClass"].strip('"') not in CLASSES or asset["fieldIndex"] != "0":
        fail(f"{name} has class {asset['fieldClass']}, index {asset['fieldIndex']}")
    color = asset["fieldDataType"] == '"float3"'
    if not color and asset["fieldDataType"] != '"float"' or color != (asset.get("vectorDataRoleHint") == '"Color"'):
        fail(f"{name} has type {asset['fieldDataType']}")
    print(name, asset["fieldName"].strip('"'), asset["fieldDataType"].strip('"'), file)
