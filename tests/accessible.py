# SPDX-License-Identifier: MIT
"""Runs axe-core and the keyboard over pages in Chromium, for tests/check_accessible.sh. Prints a line per finding.

accessible.py axe AXE.js PAGE[#STATE]...  serious and critical findings, wide by day and narrow by night; or "none"
accessible.py keyboard PAGE[#STATE]...    the order of Tab, focus, names and traps
accessible.py escape PAGE                 Escape in a viewer's page"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers"))
from chromium import Chromium  # noqa: E402

READY = "document.readyState === 'complete' && (!document.getElementById('picture') || document.documentElement.dataset.ready)"
GRAVE = ("serious", "critical")
# All folded parts are open: axe looks at what is shown only.
UNFOLD = "document.querySelectorAll('details').forEach(d => { d.open = true; })"
STATES = {
    "": "",
    "compact": "document.getElementById('settings').click()",
    "slices": "document.getElementById('slices').click(); document.getElementById('message').hidden = false;"
              "(e => { e.value = 'split'; e.dispatchEvent(new Event('change')); })(document.querySelector('#compare select')); isoshade.edits.note()",
}


def open_page(page, name):
    path, _, state = name.partition("#")
    page.call("Page.navigate", url="about:blank")  # an address with another hash alone would not load the page again
    page.open(f"file://{os.path.abspath(path)}" + ("#compact" if state == "compact" else ""), READY)
    page.evaluate(f"{UNFOLD}; {STATES[state]}")
    page.evaluate("new Promise(done => setTimeout(done, 200))")


def grave(page, source):
    """Lines "rule (impact): element" of the findings."""
    page.evaluate(source + "; null")
    found = page.evaluate("""axe.run(document, {resultTypes: ['violations']}).then(r => r.violations.flatMap(v =>
        v.nodes.map(n => [v.impact, `${v.id} (${v.impact}): ${n.target.join(' ')}: ${n.any.concat(n.all)[0]?.message ?? ''}`])))""")
    return [line for impact, line in found if impact in GRAVE]


def axe(source, *pages):
    with open(source, encoding="utf-8") as f:
        source = f.read()
    with Chromium(size=(1200, 800)) as page:
        for name in pages:
            for scheme, width in (("light", 1200), ("dark", 390)):
                page.call("Emulation.setDeviceMetricsOverride", width=width, height=800, deviceScaleFactor=1, mobile=False)
                page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                open_page(page, name)
                found = grave(page, source)
                print(name, scheme, "; ".join(found) or "none", flush=True)


# The element that has the keyboard; marks: whether that is visible.
FOCUSED = """(() => { const e = document.activeElement;
    if (!e || e === document.body) return null;
    const b = e.getBoundingClientRect();
    const isMarked = of => of && getComputedStyle(of).outlineStyle !== 'none' && parseFloat(getComputedStyle(of).outlineWidth) >= 1;
    const marks = e.matches('.point') ? !!e.closest('svg').querySelector('.chosen') : isMarked(e) || isMarked(e.closest('.open'));
    return {key: [...document.querySelectorAll('*')].indexOf(e), what: e.id || e.dataset.field || e.getAttribute('aria-label')
        || e.textContent.trim().slice(0, 24) || e.tagName, marks,
        shown: b.bottom > 0 && b.top < innerHeight && b.right > 0 && b.left < innerWidth}; })()"""
# All that the keyboard should reach, in the document's order.
ALL = """[...document.querySelectorAll('a[href], button, input, select, summary, textarea, [tabindex="0"]')].filter(e => !e.disabled
    && e.tabIndex >= 0 && e.checkVisibility({visibilityProperty: true}) && !(e.type === 'radio' && !e.checked
    && document.querySelector(`input[type=radio][name="${e.name}"]:checked`))).map(e => [...document.querySelectorAll('*')].indexOf(e))"""
# Pairs in the document's order of which the later one stands above the earlier, in one column of the page.
DISORDER = """(() => { const list = %s.map(i => document.querySelectorAll('*')[i]).filter(e => !e.matches('.point, input[type=file]'));
    const wrong = [];
    for (let i = 1; i < list.length; ++i) {
        const a = list[i - 1].getBoundingClientRect(), b = list[i].getBoundingClientRect();
        const sameColumn = a.left < b.right && b.left < a.right, sameRow = a.top < b.bottom && b.top < a.bottom;
        if ((sameColumn && !sameRow && b.bottom <= a.top) || (sameRow && !sameColumn && b.right <= a.left))
            wrong.push([list[i - 1], list[i]].map(e => e.id || e.getAttribute('aria-label') || e.textContent.trim().slice(0, 20)).join(' > '));
    }
    return wrong; })()""" % ALL


def tab(page, back=False):
    for kind in ("rawKeyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9, modifiers=8 if back else 0)
    return page.evaluate(FOCUSED)


def walk(page, count, back=False):
    """The elements that Tab reaches until it leaves the page or `count` steps are over."""
    reached = []
    for _ in range(count):
        at = tab(page, back)
        if at is None or (reached and at["key"] == reached[0]["key"]):
            break
        reached.append(at)
    return reached


def nameless(page):
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    def is_reached(node):
        return any(p["name"] == "focusable" and p["value"].get("value") for p in node.get("properties", []))
    return [n["role"]["value"] for n in nodes if is_reached(n) and n["role"]["value"] != "RootWebArea"
            and not n.get("name", {}).get("value")]


def keyboard(*pages):
    with Chromium(size=(1200, 800)) as page:
        for name in pages:
            open_page(page, name)
            wanted, disorder = page.evaluate(ALL), page.evaluate(DISORDER)
            there = walk(page, len(wanted) + 20)
            missed = [i for i in wanted if i not in {at["key"] for at in there}]
            words = page.evaluate(f"{missed}.map(i => document.querySelectorAll('*')[i]).map(e => e.id || e.outerHTML.slice(0, 60))")
            back = walk(page, len(wanted) + 20, back=True)
            print(name, "missed", "; ".join(words) or "none")
            print(name, "order", "; ".join(disorder) or "right")
            print(name, "sequence", "right" if [at["key"] for at in there] == sorted(at["key"] for at in there) else "wrong")
            print(name, "unmarked", "; ".join(at["what"] for at in there if not at["marks"]) or "none")
            print(name, "unseen", "; ".join(at["what"] for at in there if not at["shown"]) or "none")
            print(name, "back", "right" if [at["key"] for at in back][::-1] == [at["key"] for at in there] else "wrong")
            print(name, "nameless", "; ".join(nameless(page)) or "none", flush=True)


def escape(path):
    with Chromium(size=(900, 600)) as page:
        open_page(page, path + "#compact")
        panel, focused = "document.body.classList.contains('panel')", "document.activeElement.id"
        page.evaluate("document.getElementById('message').hidden = false; document.getElementById('save-width').focus()")
        page.key("Escape")
        print("closes_a_message_first", page.evaluate(f"{panel} && document.getElementById('message').hidden"))
        page.key("Escape")
        print("closes_the_panel", page.evaluate(f"!{panel} && {focused} === 'settings' && "
              "document.getElementById('settings').getAttribute('aria-expanded') === 'false'"))
        page.evaluate("document.getElementById('slices').click()")
        page.evaluate("document.querySelector('.slice canvas').focus()")
        page.key("Enter")
        large = page.evaluate("document.querySelectorAll('.large').length")
        page.key("Escape")
        print("ends_the_large_slice", large == 1 and page.evaluate("!document.querySelector('.large')"))
        page.evaluate("[...document.querySelectorAll('#slicing button')].find(b => b.textContent === 'measure a length').click()")
        measuring = page.evaluate("isoshade.state.measure !== null")
        page.key("Escape")
        print("ends_measuring", measuring and page.evaluate("isoshade.state.measure === null && isoshade.state.slices"))


if __name__ == "__main__":
    {"axe": axe, "keyboard": keyboard, "escape": escape}[sys.argv[1]](*sys.argv[2:])
