# SPDX-License-Identifier: MIT
"""Uses the viewer's pages in Chromium as a person does, for tests/check_view.sh: writes pictures as EXR, files that the
page saves, and a line a finding.

view_page.py pictures FOLDER       FOLDER/NAME.html -> FOLDER/NAME.page.exr, of SIZE pixels as FOLDER/NAME.size says
view_page.py hands PAGE FOLDER     orbit, drag a point of the transfer function, save, use every control
view_page.py saved PAGE FOLDER     saves pictures and the page after edits, opens the page and a link, undoes the edits
view_page.py times PAGE SIZE       milliseconds until the first picture, and of a picture of SIZE pixels
view_page.py load PAGE              the first picture, and the longest tasks of the page until all levels are read
view_page.py link REPORT PAGE       follows the link of a row of level 1
view_page.py shot PAGE FILE.jpg    a screenshot for the documentation
view_page.py shots PAGE FOLDER     screenshots: wide and a telephone's, light and dark"""
import base64
import glob
import json
import os
import sys
import zlib
from array import array

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers"))
from chromium import Chromium  # noqa: E402
from exr import write_exr  # noqa: E402
import view_files  # noqa: E402

READY = "document.documentElement.dataset.ready === 'yes' || document.documentElement.dataset.failed"
# The bytes of a picture as text: a list of numbers would be ten times as long.
TAKE = """isoshade.frames.settled().then(() => { const {rgba, ms} = isoshade.frames.measure(%d, %d, 'a', %d), bytes = new Uint8Array(rgba.buffer);
    let text = ''; for (let i = 0; i < bytes.length; i += 4096) text += String.fromCharCode(...bytes.subarray(i, i + 4096));
    return [btoa(text), ms]; })"""


def say(name, value):
    print(name, str(value).lower() if isinstance(value, bool) else value, flush=True)


def take(page, path, width, height, repeats=1):
    text, ms = page.evaluate(TAKE % (width, height, repeats))
    if path:
        write_exr(path, width, height, array("f", base64.b64decode(text)))
    return ms


def load(page, path):
    page.open(path, READY)
    failed = page.evaluate("document.documentElement.dataset.failed || ''")
    if failed:
        raise RuntimeError(f"{path}: {failed}")
    page.evaluate("isoshade.frames.settled()")


def middle(page, selector):
    return page.evaluate(f"(() => {{ const b = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
                         " return [b.x + b.width / 2, b.y + b.height / 2]; })()")


def pictures(folder):
    with Chromium(size=(400, 300)) as page:
        for path in sorted(glob.glob(os.path.join(folder, "*.html"))):
            name = path[:-len(".html")]
            with open(name + ".size") as f:
                width, height, state = f.read().split(maxsplit=2)
            load(page, path)
            page.evaluate(f"Object.assign(isoshade.state, {state})")
            take(page, name + ".page.exr", int(width), int(height))
            say("drawn", os.path.basename(name))


def hands(path, folder):
    with Chromium(size=(900, 560)) as page:
        load(page, path)
        state = "isoshade.state"
        page.evaluate("window.saved = {}; HTMLAnchorElement.prototype.click = function () {"
                      " window.saved[this.download] = fetch(this.href).then(r => r.text()); }")
        before = page.evaluate(f"{state}.camera.position")
        x, y = middle(page, "#picture")
        page.drag((x, y), (x + 60, y + 25))
        after = page.evaluate(f"{state}.camera.position")
        say("a_drag_orbits", max(abs(a - b) for a, b in zip(before, after)) > 1)
        target = page.evaluate(f"{state}.camera.lookAt")
        page.drag((x, y), (x + 10, y + 5), button="right")
        say("the_right_button_pans", page.evaluate(f"{state}.camera.lookAt") != target)
        half = page.evaluate(f"{state}.camera.half")
        page.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-100)
        page.wait(f"{state}.camera.half < {half}")
        say("the_wheel_zooms", True)
        position = page.evaluate(f"{state}.camera.position")
        page.evaluate("document.getElementById('picture').focus()")
        page.key("ArrowLeft")
        say("arrows_orbit", page.evaluate(f"{state}.camera.position") != position)

        point = page.evaluate(f"JSON.stringify({state}.tf.points[2])")
        px, py = middle(page, "[data-point='2']")
        page.drag((px, py), (px + 12, py - 20))
        moved = page.evaluate(f"{state}.tf.points[2]")
        say("a_point_is_dragged", moved["value"] > json.loads(point)["value"] and moved["opacity"] > json.loads(point)["opacity"])
        page.key("ArrowUp")
        raised = page.evaluate(f"{state}.tf.points[2]")
        say("keys_move_what_was_dragged", 0 < raised["opacity"] - moved["opacity"] < 0.03 and raised["value"] == moved["value"])
        count = page.evaluate(f"{state}.tf.points.length")
        page.evaluate("document.querySelector('[data-field=add]').click()")
        added = page.evaluate(f"{state}.tf.points.length")
        page.evaluate("document.querySelector('[data-field=remove]').click()")
        say("points_come_and_go", (added, page.evaluate(f"{state}.tf.points.length")) == (count + 1, count))
        page.evaluate("(e => { e.value = '#ff4000'; e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); })"
                      "(document.querySelector('[data-field=color]'))")
        say("a_color_is_chosen", page.evaluate(f"{state}.tf.points.some(p => p.r === 1 && p.b === 0)"))

        # What is saved is the picture on the screen.
        for name in ("scene", "tf"):
            page.evaluate(f"document.getElementById('save-{name}').click()")
            with open(os.path.join(folder, f"{name}.json"), "w") as f:
                f.write(page.evaluate(f"saved['{name}.json']"))
        with open(os.path.join(folder, "scene.json")) as f:
            image = json.load(f)["image"]
        page.evaluate("isoshade.frames.settled()")
        take(page, os.path.join(folder, "saved.page.exr"), image["width"], image["height"])
        with open(os.path.join(folder, "command"), "w") as f:
            f.write(page.evaluate("document.getElementById('command').textContent"))
        controls(page)

        # A and B.
        page.evaluate("(e => { e.value = 'difference'; e.dispatchEvent(new Event('change')); })(document.querySelector('#compare select'))")
        page.evaluate("isoshade.frames.settled()")
        lit = "(() => { const c = document.getElementById('picture'); isoshade.frames.reshow(); const gl = isoshade.context.gl," \
              " p = new Uint8Array(4 * c.width * c.height); gl.bindFramebuffer(gl.FRAMEBUFFER, null);" \
              " gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p); return p.filter((v, i) => i % 4 === 0 && v > 40).length; })()"
        other = page.evaluate(lit)
        said = "document.querySelector('#compare .hint:last-child').textContent"
        ten = page.evaluate(said)
        page.evaluate("(e => { e.value = 40; e.dispatchEvent(new Event('input')); })(document.querySelector('#compare input[type=range]'))")
        say("the_scale_of_a_difference_is_told", "of 0.1 or more" in ten and "of 0.025 or more" in page.evaluate(said))
        page.evaluate(f"Object.assign({state}.b, {{level: {state}.level, code: {state}.code, adapted: {state}.adapted}}); isoshade.frames.ask()")
        page.evaluate("isoshade.frames.settled()")
        same = page.evaluate(lit)
        say("a_level_differs_and_the_same_does_not", other > 0 and same == 0)

        # Other volumes, as a file that is chosen; dropped ones go the same way.
        root = page.call("DOM.getDocument")["root"]["nodeId"]
        node = page.call("DOM.querySelector", nodeId=root, selector="#open")["nodeId"]
        for name in ("other.nrrd", "other.nii.gz", "gaps.nrrd"):
            page.call("DOM.setFileInputFiles", nodeId=node, files=[os.path.abspath(os.path.join(folder, name))])
            page.wait(f"isoshade.data.title === '{name}' && document.getElementById('title').textContent === '{name}'")
            page.evaluate("isoshade.frames.settled()")
            kind = "gaps" if name == "gaps.nrrd" else name.split(".")[1]
            if kind == "gaps":  # the least values are seen, so that voxels without data would be seen with them
                page.evaluate(f"""{state}.tf = {{...{state}.tf,
                    points: {state}.tf.points.map(p => ({{...p, opacity: p.opacity + 0.05}}))}}""")
            with open(os.path.join(folder, f"opened-{kind}.json"), "w") as f:
                f.write(page.evaluate("JSON.stringify({...isoshade.controls.sceneNow(), image: {width: 80, height: 80}})"))
            # The scene has the camera of the page's own shape: the same one for a square picture.
            page.evaluate("isoshade.state.camera = isoshade.frames.camera(isoshade.frames.size()[0] / isoshade.frames.size()[1]);"
                          " isoshade.state.sceneAspect = 1")
            take(page, os.path.join(folder, f"opened-{kind}.page.exr"), 80, 80)
        page.evaluate("document.querySelector('[data-field=joint]').click()")
        say("the_joint_histogram_is_drawn", page.evaluate("document.querySelector('svg image')?.getAttribute('href').length > 1000"))

        say("files_go_wrong", "; ".join(view_files.open_files(page, folder, os.environ["ISOSHADE"])) or "none")
        drop(page, os.path.join(folder, "text.nii"))
        said = "document.querySelector('#message span').textContent"
        page.wait(f"{said}.startsWith('text.nii: ')")
        page.evaluate("document.getElementById('close-message').click()")
        say("a_complaint_is_closed", page.evaluate("document.getElementById('message').hidden"))
        drop(page, os.path.join(folder, "other.nrrd"))
        page.wait("isoshade.data.title === 'other.nrrd'")
        say("a_file_may_miss_the_picture", page.evaluate("location.pathname").endswith(os.path.basename(path)))
        say("controls_without_a_name", len(nameless(page)))
        say("fetched", page.evaluate("performance.getEntriesByType('resource').filter(r => !/^(data|blob):/.test(r.name)).length"))
        page.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
        say("wider_than_a_telephone", page.evaluate("document.documentElement.scrollWidth > 390"))
        say("exceptions", sum(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def link_of(state):
    """The state in a link: JSON, deflated, in base64 for addresses."""
    text = state if isinstance(state, str) else json.dumps(state)
    return base64.urlsafe_b64encode(zlib.compress(text.encode())).decode().rstrip("=")


def saved(path, folder):
    state, files = "JSON.stringify(isoshade.state)", os.path.join
    catch = """window.saved = {};
        const inBase64 = blob => new Promise(done => {
            const reader = new FileReader();
            reader.onload = () => done(reader.result.split(',')[1]);
            reader.readAsDataURL(blob);
        });
        HTMLAnchorElement.prototype.click = function () {
            window.saved[this.download] = fetch(this.href).then(r => r.blob()).then(inBase64);
        }"""

    def press(page, button, name, path):
        page.evaluate(f"document.getElementById('{button}').click()")
        page.wait(f"window.saved['{name}']")
        with open(path, "wb") as f:
            f.write(base64.b64decode(page.evaluate(f"saved['{name}']")))
        page.evaluate(f"delete saved['{name}']")

    with Chromium(size=(900, 560)) as page:
        load(page, path)
        page.evaluate(catch)
        before = page.evaluate(state)
        say("nothing_to_undo", page.evaluate("document.getElementById('undo').disabled"))
        page.evaluate("(e => { e.value = 0.37; e.dispatchEvent(new Event('change')); })(document.querySelector('[data-field=opacity]'))")
        page.evaluate("isoshade.frames.settled().then(() => isoshade.edits.note())")
        page.evaluate("[...document.querySelectorAll('#views button')].find(b => b.textContent === 'left').click()")
        page.evaluate("isoshade.state.lights[0].intensity = 0.2; isoshade.frames.ask()")
        page.evaluate("isoshade.frames.settled().then(() => isoshade.edits.note())")
        after = page.evaluate(state)
        page.evaluate("document.getElementById('undo').click()")
        once = page.evaluate(state)
        page.evaluate("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'z', ctrlKey: true}))")
        say("undo_goes_back", before != once != after and page.evaluate(state) == before)
        for _ in range(2):
            page.evaluate("document.getElementById('redo').click()")
        say("redo_comes_again", page.evaluate(state) == after)
        say("nothing_to_redo", page.evaluate("document.getElementById('redo').disabled"))
        page.evaluate("isoshade.frames.settled()")
        page.wait("location.hash.startsWith('#state=')")
        width = page.evaluate("isoshade.frames.size()[0]")
        press(page, "save-picture", "v.png", files(folder, "screen.png"))
        press(page, "save-scene", "scene.json", files(folder, "edited.scene.json"))
        page.evaluate(f"document.getElementById('save-width').value = {3 * width}")
        press(page, "save-picture", "v.png", files(folder, "print.png"))
        press(page, "save-page", "v.html", files(folder, "edited.html"))
        take(page, files(folder, "edited.page.exr"), 91, 60)
        link = page.evaluate("location.href")
        say("exceptions_in_the_page", sum(e["method"] == "Runtime.exceptionThrown" for e in page.events))
    with Chromium(size=(900, 560)) as page:
        load(page, files(folder, "edited.html"))
        page.evaluate(catch)
        say("the_saved_page_is_as_it_was_left", page.evaluate(state) == after)
        take(page, files(folder, "again.page.exr"), 91, 60)
        press(page, "save-page", "v.html", files(folder, "again.html"))
        with open(files(folder, "edited.html"), "rb") as a, open(files(folder, "again.html"), "rb") as b:
            say("saved_again_it_is_the_same", a.read() == b.read())
        say("exceptions_in_the_saved_page", sum(e["method"] == "Runtime.exceptionThrown" for e in page.events))
        load(page, link)
        say("the_link_shows_the_same", page.evaluate(state) == after)
        whole = json.loads(after)
        forged = {"no_text": "x", "empty": link_of("{}"), "no_camera": link_of({**whole, "camera": None}),
                  "nine_lights": link_of({**whole, "lights": 9 * whole["lights"]})}
        for name, text in forged.items():
            page.evaluate(f"location.hash = 'state={text}'")
            page.wait("!document.getElementById('message').hidden")
            say(f"refused_{name}", page.evaluate(state) == after)
            page.evaluate("document.getElementById('close-message').click()")
        say("exceptions_after_forged_links", sum(e["method"] == "Runtime.exceptionThrown" for e in page.events))


def drop(page, path):
    """A file, on the panel beside the picture."""
    x, y = middle(page, "aside")
    for kind in ("dragEnter", "dragOver", "drop"):
        page.call("Input.dispatchDragEvent", type=kind, x=x, y=y, data={"items": [], "files": [os.path.abspath(path)], "dragOperationsMask": 1})


def nameless(page):
    """What the keyboard reaches and a screen reader has no name for."""
    nodes = page.call("Accessibility.getFullAXTree")["nodes"]
    reached = [n for n in nodes if any(p["name"] == "focusable" and p["value"].get("value") for p in n.get("properties", []))]
    return [n["role"]["value"] for n in reached if not n.get("name", {}).get("value")] if len(reached) > 20 else ["the tree is empty"]


def controls(page):
    """What a control does to the others, and where the keyboard is afterwards."""
    state, focused = "isoshade.state", "document.activeElement"

    def change(selector, value):
        page.evaluate(f"(e => {{ e.focus(); e.value = '{value}'; e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); }})"
                      f"(document.querySelector({json.dumps(selector)}))")

    def press(part, text):
        page.evaluate(f"(b => {{ b.focus(); b.click(); }})([...document.querySelectorAll('#{part} button')].find(b => b.textContent === '{text}'))")

    page.evaluate("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    edited = page.evaluate(f"JSON.stringify({state}.tf)")
    change("#preset select", "microscopy")
    other = page.evaluate(f"JSON.stringify({state}.tf)")
    change("#preset select", "edited")
    say("what_was_edited_comes_back", other != edited and page.evaluate(f"JSON.stringify({state}.tf)") == edited)
    change("[data-field=value]", "")
    say("an_empty_field_changes_nothing", page.evaluate(f"JSON.stringify({state}.tf)") == edited
        and page.evaluate("document.querySelector('[data-field=value]').value") != "")

    change("#projection select", "orthographic")
    press("views", "scene")
    say("the_projection_follows_the_scene", page.evaluate("document.querySelector('#projection select').value") == "perspective")

    # In a window that is narrower than the scene's picture all of that is seen; a view of the box takes no more than it needs.
    seen = "(() => { const c = isoshade.frames.camera(0.5); return c.half * 0.5; })()"
    page.evaluate(f"{state}.sceneAspect = 1.5")
    sides = page.evaluate(seen) >= page.evaluate(f"{state}.camera.half") * 1.5 * 0.9999
    press("views", "front")
    framed = page.evaluate(seen) <= page.evaluate(f"{state}.camera.half") * 1.0001
    press("views", "scene")
    say("a_narrow_window_shows_the_scenes_sides", sides and framed)

    kept = []
    press("lights", "add a light")
    kept.append(page.evaluate(f"{focused}.textContent") == "add a light")
    press("lights", "remove")
    kept.append(page.evaluate(f"{focused}.closest('#lights') !== null"))
    change("#shading input[aria-label=ambient]", "0.9")  # the diffuse part gives way
    kept.append(page.evaluate(f"{focused}.getAttribute('aria-label')") == "ambient")
    change("#compare select", "split")
    kept.append(page.evaluate(f"{focused} === document.querySelector('#compare select')"))
    say("the_keyboard_stays_where_it_was", all(kept))
    change("#compare select", "none")

    level = page.evaluate(f"{state}.level")
    page.evaluate("document.querySelector('#roi input').click()")
    page.evaluate("isoshade.frames.settled()")
    lines = page.evaluate("document.querySelector('#outline path').getAttribute('d').split('M').length - 1")
    page.evaluate("document.querySelector('#roi input').click()")
    say("a_region_is_outlined_and_goes", lines == 12 and page.evaluate(f"{state}.level") == level)


def processor_seconds(root):
    """Of a process and all below it."""
    parents, seconds = {}, {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as f:
                fields = f.read().rsplit(")", 1)[1].split()
        except OSError:
            continue
        parents[int(name)], seconds[int(name)] = int(fields[1]), (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    inside, grew = {root}, True
    while grew:
        more = {p for p, parent in parents.items() if parent in inside} - inside
        grew, inside = bool(more), inside | more
    return sum(seconds.get(p, 0) for p in inside)


def times(path, size):
    with Chromium() as page:
        load(page, path)
        say("first_picture_ms", page.evaluate("document.documentElement.dataset.first"))
        take(page, None, 8, 8)
        runs, before = 6, processor_seconds(page.process.pid)
        say("frame_ms", f"{take(page, None, size, size, runs):.1f}")
        say("frame_processor_ms", f"{(processor_seconds(page.process.pid) - before) / runs * 1000:.0f}")
        say("renderer", page.evaluate("isoshade.context.renderer"))


def loading(path):
    """Milliseconds, as the DevTools protocol traces the page's own thread; of a task also the processor's."""
    with Chromium(size=(900, 700)) as page:
        page.call("Tracing.start", transferMode="ReportEvents", traceConfig={"includedCategories": ["toplevel", "__metadata"]})
        load(page, path)
        first = page.evaluate("[document.documentElement.dataset.first, performance.getEntriesByType('navigation')[0].loadEventEnd]")
        page.call("Tracing.end")
        while not any(e["method"] == "Tracing.tracingComplete" for e in page.events):
            page.events.append(page.receive())
        events = [e for part in page.events if part["method"] == "Tracing.dataCollected" for e in part["params"]["value"]]
        main = {(e["pid"], e["tid"]) for e in events if e.get("args", {}).get("name") == "CrRendererMain"}
        tasks = [e for e in events if e["name"].endswith("RunTask") and (e["pid"], e["tid"]) in main]
        say("first_picture_ms", first[0])
        say("load_event_ms", round(first[1]))
        say("tasks", len(tasks))
        for key, name in (("dur", "longest_tasks_ms"), ("tdur", "of_the_processor_ms")):
            say(name, " ".join(str(round(t / 1e3)) for t in sorted((e.get(key, 0) for e in tasks), reverse=True)[:8]))


def shots(path, folder):
    with Chromium(size=(1200, 780)) as page:
        load(page, path)
        for scheme in ("light", "dark"):
            for name, width, height in (("wide", 1200, 780), ("telephone", 390, 844)):
                page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 500)
                page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                page.evaluate("new Promise(done => setTimeout(done, 400)).then(() => isoshade.frames.settled())")
                page.screenshot(os.path.join(folder, f"{name}-{scheme}.png"))


def link(report, name):
    with Chromium(size=(500, 300)) as page:
        page.open(os.path.join(report, "index.html"), "document.documentElement.dataset.ready === 'yes'")
        hrefs = page.evaluate("""(async () => { const list = [], select = document.querySelector('#inspector select');
            for (const option of select.options) { select.value = option.value; select.dispatchEvent(new Event('change'));
                await new Promise(done => setTimeout(done, 40));
                list.push([option.textContent, document.querySelector('#inspector a[href^="viewer"]')?.getAttribute('href') || '']); }
            return list; })()""")
        if not hrefs or any(not href.startswith(name + "#level=") for _, href in hrefs):
            sys.exit(f"rows without a link: {hrefs[:3]}")
        href = next(href for _, href in hrefs if "level=1" in href and "code=none" in href)
        load(page, "file://" + os.path.abspath(os.path.join(report, href)))
        shown = page.evaluate("[isoshade.state.level, isoshade.state.code, document.querySelector('#what select').value]")
        if shown != [1, None, "1"]:
            sys.exit(f"{href} shows {shown}")


def shot(path, picture):
    with Chromium(size=(1200, 760)) as page:
        load(page, path)
        page.screenshot(picture, "jpeg", 82)


if __name__ == "__main__":
    if sys.argv[1] == "times":
        times(sys.argv[2], int(sys.argv[3]))
    else:
        commands = {"pictures": pictures, "hands": hands, "saved": saved, "load": loading, "shots": shots, "shot": shot, "link": link}
        commands[sys.argv[1]](*sys.argv[2:])
