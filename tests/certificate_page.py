# SPDX-License-Identifier: MIT
"""Uses a site of certificates in Chromium as a reader does, for tests/check_certificate.sh: a line per finding.

certificate_page.py INDEX.html            findings
certificate_page.py INDEX.html OUT.png    a screenshot of its top"""
import base64
import json
import sys

from chart_page import READY, say, size
from chromium import Chromium

CARDS = "[...document.querySelectorAll('.cards .card')]"
COLORS = """[...document.querySelectorAll('.card canvas')].map(c => {
    const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
    return new Set(Array.from({length: p.length / 4}, (_, i) => p.slice(4 * i, 4 * i + 3).join())).size; })"""
NAMED = """[...document.querySelectorAll('button, select, input, a, img, canvas[tabindex]')].every(e =>
    e.getAttribute('aria-label') || e.getAttribute('alt') || e.textContent.trim() || e.closest('label'))"""
LEADS = """[...document.querySelectorAll('#overview tbody a')].every(a =>
    document.getElementById(decodeURIComponent(a.hash.slice(1)))?.classList.contains('card'))"""
FETCHED = "performance.getEntriesByType('resource').filter(r => !/^(data|blob):/.test(r.name)).length"


def shown(page):
    return page.evaluate(f"{CARDS}.map(c => c.id)")


def choose(page, select, value):
    """The ids of the cards, in their order, after a choice."""
    page.evaluate(f"""(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('change')); }})
        (document.querySelector('#cards [{select}]'))""")
    return shown(page)


def look(page, cards, names):
    """What stands on the page."""
    bad = next(i for i, c in enumerate(cards) if c["verdict"] != "agree" and not c["missing"])
    texts = page.evaluate(f"{CARDS}.map(c => c.textContent)")
    say("a_card_for_each", shown(page) == names)
    say("cells", page.evaluate("document.querySelectorAll('#overview tbody a').length"))
    say("each_cell_leads_to_its_card", page.evaluate(LEADS))
    badges = page.evaluate("[...document.querySelectorAll('#overview img')].map(i => i.naturalWidth)")
    say("badges_are_shown", min(badges) > 80)
    say("a_bad_card_names_the_mistake", bool(cards[bad]["mistake"]) and cards[bad]["mistake"] in texts[bad])
    named = page.evaluate("[...document.querySelectorAll('.card .mistake img')].map(i => [i.alt, i.naturalWidth])")
    say("a_bad_card_shows_the_mistake", named == [["wanted", 32], ["got", 32]])
    say("cards_have_command_and_version",
        all((c["command"] or "") in t and c["version"] in t for c, t in zip(cards, texts)))


def choices(page, cards, names):
    """Filters and sorting."""
    good = [n for c, n in zip(cards, names) if c["verdict"] == "agree"]
    say("the_verdict_filters", choose(page, "data-filter=verdict", "agree") == good)
    choose(page, "data-filter=verdict", "")
    cpu = [n for c, n in zip(cards, names) if c["renderer"] == "cpu"]
    say("the_renderer_filters", choose(page, "data-filter=renderer", "cpu") == cpu)
    choose(page, "data-filter=renderer", "")
    rmse = [cards[names.index(n)]["rmse"] for n in choose(page, "data-sort", "RMSE")]
    known = [x for x in rmse if x is not None]
    say("rmse_sorts", len(rmse) == len(cards) and known == sorted(known, reverse=True))
    page.evaluate("[...document.querySelectorAll('#cards button')].find(b => b.textContent === 'all').click()")
    say("all_comes_back", shown(page) == names and page.evaluate("document.querySelector('[data-sort]').value") == "")


def differences(page):
    """They are painted when they come into view, and have colors then. The inspector has three pictures."""
    painted = page.evaluate(f"{CARDS}.map((c, i) => c.querySelector('canvas') ? i : -1).filter(i => i >= 0)")
    for number in painted:
        page.evaluate(f"{CARDS}[{number}].scrollIntoView()")
        page.wait(f"{CARDS}[{number}].querySelector('canvas').width > 1")
    say("differences_are_painted", len(painted) > 1 and min(page.evaluate(COLORS)) > 1)
    page.evaluate(f"{CARDS}.map(c => c.lastChild).find(b => b.textContent === 'inspect').click()")
    panels = "[...document.querySelectorAll('#inspector .panel canvas')]"
    page.wait(f"{panels}.filter(c => c.clientWidth > 100).length === 3")
    say("two_pictures_and_their_difference_are_inspected", page.evaluate("location.hash").startswith("#case-"))


def findings(path):
    with Chromium(size=(1300, 1000)) as page:
        size(page, 1300, 1000)
        page.open(path, READY)
        cards = page.evaluate("JSON.parse(document.getElementById('data').textContent).certificates")
        names = [f"{c['renderer']}:{c['scene'].replace(' ', '-')}" for c in cards]
        look(page, cards, names)
        choices(page, cards, names)
        differences(page)
        size(page, 390, 844, "dark")
        page.open(path, READY)
        say("dark_is_dark", page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(23, 24, 27)")
        say("wider_than_a_telephone", page.evaluate("document.documentElement.scrollWidth > 390"))
        say("every_control_has_a_name", page.evaluate(NAMED))
        say("pictures_broken", page.evaluate("[...document.images].filter(i => i.complete && !i.naturalWidth).length"))
        say("fetched", page.evaluate(FETCHED))
        say("exceptions", sum(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def shot(path, picture):
    """The overview, and the first cards of a scene."""
    area = {"x": 0, "y": 340, "width": 1240, "height": 1330, "scale": 0.56}
    with Chromium(size=(1300, 1000)) as page:
        size(page, 1240, 2000)
        page.open(path, READY)
        choose(page, "data-filter=scene", "marschner-lobb")
        page.wait(f"{CARDS}.slice(0, 3).every(c => c.querySelector('canvas').width > 1)")
        data = page.call("Page.captureScreenshot", format="png", clip=area)["data"]
    with open(picture, "wb") as f:
        f.write(base64.b64decode(data))


if __name__ == "__main__":
    shot(*sys.argv[1:]) if len(sys.argv) > 2 else findings(sys.argv[1])
