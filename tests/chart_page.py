# SPDX-License-Identifier: MIT
"""Uses a chart's page in Chromium as a person does, for tests/check_chart_page.sh, and writes a line a finding.

chart_page.py INDEX.html            findings
chart_page.py INDEX.html FOLDER     screenshots: wide and a telephone's, light and dark"""
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers"))
from chromium import Chromium  # noqa: E402

READY = "document.documentElement.dataset.ready === 'yes'"


def say(name, value):
    print(name, str(value).lower() if isinstance(value, bool) else value, flush=True)


def size(page, width, height, scheme="light"):
    page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 500)
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])


def findings(path):
    with Chromium(size=(1300, 1000)) as page:
        size(page, 1300, 1000)
        page.open(path, READY)
        data = page.evaluate("JSON.parse(document.getElementById('data').textContent)")
        first = [c for c in data["cases"] if c["scene"] == data["scenes"][0]["name"]]
        say("the_plot_has_every_setting", page.evaluate("document.querySelectorAll('#plot .point').length") == len(first))

        # Pointing at the mark that is the farthest from its neighbors: others may lie on each other.
        at = page.evaluate("(() => { document.querySelector('#plot').scrollIntoView({block: 'center'});"
                           " const all = [...document.querySelectorAll('#plot .point')].map(p => { const b = p.getBoundingClientRect();"
                           " return [b.x + b.width / 2, b.y + b.height / 2, Number(p.dataset.case)]; });"
                           " const alone = p => Math.min(...all.filter(q => q !== p).map(q => Math.hypot(q[0] - p[0], q[1] - p[1])));"
                           " return all.reduce((a, b) => alone(b) > alone(a) ? b : a); })()")
        page.call("Input.dispatchMouseEvent", type="mouseMoved", x=at[0], y=at[1])
        page.wait(f"document.querySelector('#setting code').textContent === {json.dumps(data['cases'][at[2]]['command'])}")
        say("pointing_shows_its_picture_and_command", page.evaluate(
            f"document.querySelector('#setting h3').textContent.endsWith({json.dumps(data['cases'][at[2]]['setting'])}) &&"
            " [...document.querySelectorAll('#setting img')].every(i => i.naturalWidth > 8)"))

        # Keys: along the front, whose errors fall while times rise.
        page.evaluate("document.querySelector('#plot svg').focus()")
        page.key("Home")
        page.key("ArrowUp")
        walked = []
        for _ in range(6):
            walked.append(page.evaluate("document.querySelector('#setting h3').textContent"))
            page.key("ArrowDown")
        front = [c["setting"] for c in sorted(first, key=lambda c: c["milliseconds"]) if c["on_time_front"]]
        names = [w.split("  ")[-1] for w in walked]
        steps = [n for i, n in enumerate(names) if i == 0 or n != names[i - 1]]
        say("keys_go_along_the_front", steps == front[:len(steps)] and len(steps) == min(len(front), 6))

        page.evaluate("(e => { e.value = e.options[1].value; e.dispatchEvent(new Event('change')); })(document.querySelector('#controls select'))")
        shown = page.evaluate("[...document.querySelectorAll('#plot .point')].map(p => Number(p.dataset.case))")
        say("a_scene_is_chosen", all(data["cases"][i]["scene"] == data["scenes"][1]["name"] for i in shown) and len(shown) > 0)
        page.evaluate("document.querySelector('[data-own=yes]').click()")
        say("fronts_of_renderers_are_drawn", page.evaluate("[...document.querySelectorAll('#plot .own')].map(p => p.dataset.renderer).join()")
            == ",".join(dict.fromkeys(c["renderer"] for c in data["cases"])))
        page.evaluate("document.querySelector('[data-cost=bytes]').click()")
        say("bytes_are_drawn", page.evaluate("document.querySelector('#plot').textContent.includes('bytes that the renderer holds')"))
        page.evaluate("document.querySelector('[data-cost=milliseconds]').click()")

        coarse = next(c for c in data["cases"] if c["level"] == 1 and c["on_renderer_time_front"])
        page.evaluate("(e => { e.value = %s; e.dispatchEvent(new Event('change')); })(document.querySelector('#controls select'))" % json.dumps(coarse["scene"]))
        page.evaluate("[...document.querySelectorAll('#settings tr[data-case]')].find(r => r.dataset.case === '%d').querySelector('button').click()"
                      % data["cases"].index(coarse))
        href = page.evaluate("document.querySelector('#setting a').getAttribute('href')")
        there = os.path.exists(os.path.join(os.path.dirname(path), href.split("#")[0]))
        # Later, since an answer may not come from a page that is left.
        page.evaluate("void setTimeout(() => document.querySelector('#setting a').click())")
        page.wait("window.isoshade && document.documentElement.dataset.ready === 'yes'")
        state = page.evaluate("[isoshade.state.level, isoshade.state.step]")
        say("it_links_to_the_viewer_at_its_level", there and state == [1, coarse["step_voxels"]])

        size(page, 390, 844, "dark")
        page.open(path, READY)
        say("dark_is_dark", page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(23, 24, 27)")
        say("labels_are_whole", page.evaluate("(() => { const edge = document.querySelector('#plot svg').getBoundingClientRect();"
            " return [...document.querySelectorAll('#plot text')].every(t => { const b = t.getBoundingClientRect();"
            " return b.left >= edge.left - 0.5 && b.right <= edge.right + 0.5; }); })()"))
        say("wider_than_a_telephone", page.evaluate("document.documentElement.scrollWidth > 390"))
        say("every_control_has_a_name", page.evaluate(
            "[...document.querySelectorAll('button, select, input, a, svg[tabindex], img')].every(e =>"
            " e.getAttribute('aria-label') || e.getAttribute('alt') || e.textContent.trim() || e.closest('label'))"))
        say("fetched", page.evaluate("performance.getEntriesByType('resource').filter(r => !/^(data|blob):/.test(r.name)).length"))
        say("exceptions", sum(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def shots(path, folder):
    with Chromium(size=(1300, 1000)) as page:
        for name, width, height, scheme in (("wide", 1180, 1010, "light"), ("wide-dark", 1180, 1010, "dark"), ("telephone", 390, 1900, "dark")):
            size(page, width, height, scheme)
            page.open(path, READY)
            page.screenshot(os.path.join(folder, f"{name}.jpg"), "jpeg", 88)


if __name__ == "__main__":
    shots(*sys.argv[1:]) if len(sys.argv) > 2 else findings(sys.argv[1])
