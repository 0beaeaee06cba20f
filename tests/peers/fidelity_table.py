# SPDX-License-Identifier: MIT
"""Prints certificates.json as two tables in Markdown: figures by renderer and scene, and reasons by renderer.

fidelity_table.py CERTIFICATES.json"""
import json
import sys

MARKS = {"agree": "", "differ": " ✗", "refused": " ⊘", "not compared": ""}


def figure(value):
    if value == 0:
        return "0"
    if value < 1e-3 / 255:
        return f"{255 * value:.0e}".replace("e-0", "e-")
    return f"{255 * value:.2g}" if value < 99.5 / 255 else f"{255 * value:.0f}"


def cell(c):
    """RMSE and largest difference of a certificate's picture, in 1/255."""
    if c is None or c["missing"]:
        return "not available" if c else ""
    if c["rmse"] is None:
        return "–"
    return f"{figure(c['rmse'])}, {figure(c['max_abs'])}{MARKS[c['verdict']]}"


def reason(rows):
    """Of the renderer's worst certificate: the mistake, or the cause of its limits."""
    about = rows[0]
    worst = next((c for c in rows if c["verdict"] in ("differ", "refused")), about)
    mistake = f"draws {worst['mistake']}" if worst["mistake"] else ""
    why = worst["why"] if worst["missing"] else about["limits_why"] or ""
    return "; ".join(filter(None, (mistake, why)))


def main():
    with open(sys.argv[1], encoding="utf-8") as f:
        site = json.load(f)
    cards, scenes = site["certificates"], []
    for c in cards:
        key = (c["volume"], c["scene"])
        scenes += [key] if key not in scenes else []
    of = {(c["renderer"], c["volume"], c["scene"]): c for c in cards}
    print("| renderer |", " | ".join(name for _, name in scenes), "|")
    print("|---" * (len(scenes) + 1) + "|")
    for r in site["renderers"]:
        print(f"| {r['title']} |", " | ".join(cell(of.get((r["renderer"], *s))) for s in scenes), "|")
    print("\n| renderer | verdict | why |\n|---|---|---|")
    for r in site["renderers"]:
        rows = [c for c in cards if c["renderer"] == r["renderer"]]
        why = reason(rows) or "limits of halved steps"
        print(f"| {r['title']} | {r['words']} | {why} |")


main()
