// SPDX-License-Identifier: MIT
// The inspector: the two images of a case and their difference, side by side, in turn, or divided by a slider. A case has a
// row (image_a and image_b, their names a and b, number) and its index `at`; the page's other functions are in `handlers`.
let cases = [], handlers = null;
const view = {at: -1, mode: 'side', flip: 'a', threshold: -5, part: 0.5, zoom: 1, x: 0.5, y: 0.5, timer: 0};
let parts = null;

// handlers: pictures(row) that can be compared, as [name, label], or nothing; name(row) in the list, text(row) below the images, threshold(row), listed() indices in the reader's order, mark(at), figure
function buildInspector(itsCases, pageHandlers) {
    const section = $('inspector');
    cases = itsCases;
    handlers = pageHandlers;
    section.hidden = false;
    const select = el('select', {'aria-label': 'case', onchange: () => inspect(Number(select.value), false)},
        cases.map(c => el('option', {value: c.at}, handlers.name(c.row))));
    const walk = el('span', {class: 'group'}, el('button', {type: 'button', onclick: () => next(-1)}, '‹ previous'), el('button', {type: 'button', onclick: () => next(1)}, 'next ›'));
    const modes = {side: 'side by side', flip: 'flip A/B', part: 'slider', difference: 'difference'};
    const buttons = Object.entries(modes).map(([mode, name]) => el('button', {type: 'button', 'data-mode': mode, onclick: () => { view.mode = mode; show(); }}, name));
    const flipButton = el('button', {type: 'button', onclick: swap}, 'swap (space)');
    const auto = el('button', {type: 'button', 'aria-pressed': 'false', onclick: () => {
        if (view.timer) { clearInterval(view.timer); view.timer = 0; } else view.timer = setInterval(swap, 500);
        auto.setAttribute('aria-pressed', String(view.timer !== 0));
    }}, 'twice a second');
    const slider = el('input', {type: 'range', min: -9, max: 0, step: 0.05, 'aria-label': 'threshold', oninput: () => { view.threshold = Number(slider.value); show(); }});
    const value = el('output', {});
    const place = el('input', {type: 'range', min: 0, max: 1, step: 0.005, 'aria-label': 'where a ends and b begins', oninput: () => { view.part = Number(place.value); show(); }});
    const pick = side => el('select', {'aria-label': `picture ${side}`, 'data-picture': side, onchange: () => compareChosen()});
    const zoomTo = factor => { view.zoom = Math.min(Math.max(view.zoom * factor, 1), 64); clampView(); show(); };
    const reset = () => zoomTo(0);
    const panel = name => {
        const canvas = el('canvas', {tabindex: 0, role: 'img', 'aria-label': name});
        const label = el('span', {'aria-live': 'polite'});
        attachPointer(canvas);
        return {box: el('div', {class: 'panel'}, canvas, label), canvas, label};
    };
    parts = {select, slider, value, place, picks: {a: pick('a'), b: pick('b')}, a: panel('image a'), b: panel('image b'), d: panel('difference'), p: panel('image a, and b to the right'),
        partGroup: el('label', {}, 'a', place, 'b'),
        flipGroup: el('span', {class: 'group'}, flipButton, auto), thresholdGroup: el('label', {}, 'differences above', slider, value),
        panels: el('div', {class: 'panels'}), readout: el('p', {class: 'readout'}, '\u00a0'), text: el('div', {}), buttons};
    parts.panels.append(parts.a.box, parts.b.box, parts.d.box, parts.p.box);
    section.append(el('div', {class: 'controls'}, walk, select), handlers.pictures ? el('div', {class: 'controls'}, el('label', {}, 'a', parts.picks.a), el('label', {}, 'b', parts.picks.b)) : '', el('div', {class: 'controls'}, el('span', {class: 'group'}, buttons), parts.flipGroup, parts.thresholdGroup, parts.partGroup,
        el('span', {class: 'group'}, el('button', {type: 'button', 'aria-label': 'zoom in', onclick: () => zoomTo(1.5)}, '+'),
            el('button', {type: 'button', 'aria-label': 'zoom out', onclick: () => zoomTo(1 / 1.5)}, '−'), el('button', {type: 'button', onclick: reset}, 'whole'))),
        el('figure', {}, parts.panels, parts.readout, legend(), figcaption(handlers.figure + ' and the largest difference of their channels at each pixel, on one log scale for all cases; cyan marks pixels that are not finite. ' +
            'All panels zoom (wheel) and move (drag) in step; a double click shows the whole image. Keys: f flips, space swaps, s side by side, w the slider, d difference, ' +
            'n and p the next and the previous case of the table, + − 0 and arrows zoom and move. Panels are 8-bit; the report\'s .exr files are what was compared.')), parts.text);
    const move = (x, y) => { view.x += x / view.zoom; view.y += y / view.zoom; clampView(); show(); };
    const mode = name => { view.mode = name; show(); };
    const keys = {f: () => view.mode === 'flip' ? swap() : mode('flip'), s: () => mode('side'), w: () => mode('part'), d: () => mode('difference'), n: () => next(1), p: () => next(-1),
        '+': () => zoomTo(1.5), '=': () => zoomTo(1.5), '-': () => zoomTo(1 / 1.5), 0: reset};
    const arrows = {ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0), ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1)};
    document.addEventListener('keydown', e => {
        const on = document.activeElement, inside = section.contains(on);
        if (e.ctrlKey || e.altKey || e.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(on.tagName)) return;
        // Space presses the focused button; the button that started flipping keeps flipping.
        const swaps = e.key === ' ' && view.mode === 'flip' && (on === document.body || on.tagName === 'CANVAS' || on.dataset.mode === 'flip');
        const act = swaps ? swap : keys[e.key] || (inside && on.tagName === 'CANVAS' && view.zoom > 1 ? arrows[e.key] : null);
        if (act) { e.preventDefault(); act(); }
    });
    addEventListener('hashchange', followHash);
    addEventListener('resize', show);
}
// The next case in the table, in the reader's order.
function next(step) {
    const list = handlers.listed().filter(at => cases.some(c => c.at === at)), here = list.indexOf(view.at);
    if (list.length) inspect(list[here < 0 ? 0 : (here + step + list.length) % list.length], false);
}
function swap() { view.flip = view.flip === 'a' ? 'b' : 'a'; show(); }
function clampView() {
    const half = 0.5 / view.zoom;
    view.x = Math.min(Math.max(view.x, half), 1 - half);
    view.y = Math.min(Math.max(view.y, half), 1 - half);
}
function attachPointer(canvas) {
    let drag = null;
    const place = e => {
        const r = canvas.getBoundingClientRect();
        return {u: view.x + ((e.clientX - r.left) / r.width - 0.5) / view.zoom, v: view.y + ((e.clientY - r.top) / r.height - 0.5) / view.zoom, r};
    };
    canvas.addEventListener('wheel', e => {
        if (e.deltaY > 0 && view.zoom === 1) return; // already at full size: the page scrolls
        e.preventDefault();
        const before = place(e), zoom = Math.min(Math.max(view.zoom * Math.exp(-e.deltaY * 0.002), 1), 64);
        view.x = before.u + (view.x - before.u) * view.zoom / zoom;
        view.y = before.v + (view.y - before.v) * view.zoom / zoom;
        view.zoom = zoom;
        clampView();
        show();
    }, {passive: false});
    canvas.addEventListener('pointerdown', e => { drag = {x: e.clientX, y: e.clientY}; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener('pointerup', () => { drag = null; });
    canvas.addEventListener('dblclick', () => { view.zoom = 1; clampView(); show(); });
    canvas.addEventListener('pointermove', e => {
        const p = place(e);
        if (drag) {
            view.x -= (e.clientX - drag.x) / p.r.width / view.zoom;
            view.y -= (e.clientY - drag.y) / p.r.height / view.zoom;
            drag = {x: e.clientX, y: e.clientY};
            clampView();
            show();
        }
        readout(p.u, p.v);
    });
}
let loaded = null;
function readout(u, v) {
    if (!loaded) return;
    const {a, b, d} = loaded, x = Math.floor(u * a.width), y = Math.floor(v * a.height);
    if (x < 0 || y < 0 || x >= a.width || y >= a.height) return;
    const i = y * a.width + x, rgb = p => Array.from(p.bytes.slice(4 * i, 4 * i + 3)).join(' ');
    const log = d.logs[i], text = log === Infinity ? 'not finite' : log === -Infinity ? '0' : (10 ** log).toExponential(2);
    parts.readout.textContent = `column ${x}, row ${y}:  a ${rgb(a)}   b ${rgb(b)} (sRGB)   difference ${text}`;
}
// Draws the part in view, with square pixels once they are large. over: another image, drawn from column `from` (0 to 1) on.
function draw(panel, source, name, note, over, from) {
    const width = Math.max(Math.round(panel.canvas.clientWidth * (devicePixelRatio || 1)), 64);
    const height = Math.round(width * source.height / source.width);
    panel.canvas.width = width;
    panel.canvas.height = height;
    const context = panel.canvas.getContext('2d'), scale = width / source.width * view.zoom;
    context.imageSmoothingEnabled = scale < 1;
    const put = image => context.drawImage(image, width / 2 - view.x * source.width * scale, height / 2 - view.y * source.height * scale, source.width * scale, source.height * scale);
    put(source);
    if (over) {
        const at = Math.round(from * width);
        context.save();
        context.beginPath();
        context.rect(at, 0, width - at, height);
        context.clip();
        put(over);
        context.restore();
        context.fillStyle = '#fff';
        context.fillRect(at - 1, 0, 2, height);
    }
    panel.label.replaceChildren(el('strong', {}, name), note ? ` ${note}` : '');
}
function show() {
    if (!loaded) return;
    const {row, a, b, d} = loaded, side = view.mode === 'side', flip = view.mode === 'flip';
    for (const button of parts.buttons) button.setAttribute('aria-pressed', String(button.dataset.mode === view.mode));
    parts.panels.classList.toggle('one', !side);
    parts.flipGroup.hidden = !flip;
    parts.partGroup.hidden = view.mode !== 'part';
    parts.thresholdGroup.hidden = flip || view.mode === 'part';
    parts.a.box.hidden = !(side || (flip && view.flip === 'a'));
    parts.b.box.hidden = !(side || (flip && view.flip === 'b'));
    parts.d.box.hidden = flip || view.mode === 'part';
    parts.p.box.hidden = view.mode !== 'part';
    parts.place.value = view.part;
    parts.slider.value = view.threshold;
    parts.value.replaceChildren(view.threshold <= -9 ? 'any' : brief(10 ** view.threshold));
    if (!parts.a.box.hidden) draw(parts.a, a.canvas, row.a, 'a');
    if (!parts.b.box.hidden) draw(parts.b, b.canvas, nameOf(row), 'b');
    if (!parts.p.box.hidden) draw(parts.p, a.canvas, row.a, `to the left, ${nameOf(row)} to the right`, b.canvas, view.part);
    if (!parts.d.box.hidden) {
        const threshold = view.threshold <= -9 ? -Infinity : view.threshold;
        if (!loaded.painted || loaded.painted.threshold !== threshold) loaded.painted = {threshold, ...paintDifference(d, a, threshold)};
        const {canvas, above} = loaded.painted;
        draw(parts.d, canvas, loaded.rough ? 'difference of the 8-bit pictures' : 'difference', `${above} of ${d.logs.length} pixels (${Number((100 * above / d.logs.length).toPrecision(3))} %) above`);
    }
}
async function inspect(at, scroll) {
    const one = cases.find(c => c.at === at);
    if (!parts || !one) return;
    const row = one.row;
    handlers.mark(at);
    view.at = at;
    const [a, b, d] = await Promise.all([pixels(inlined.images[row.image_a]), pixels(inlined.images[row.image_b]), differences(row.number)]);
    if (view.at !== at) return; // another case was chosen meanwhile
    loaded = {row, a, b, d};
    if (handlers.pictures) for (const side of ['a', 'b']) {
        parts.picks[side].replaceChildren(...handlers.pictures(row).map(([name, label]) => el('option', {value: name}, label)));
        parts.picks[side].value = row[`image_${side}`];
    }
    parts.select.value = String(at);
    view.threshold = Math.min(Math.max(Math.round(Math.log10(handlers.threshold(row)) * 20) / 20, -9), 0);
    parts.text.replaceChildren(...handlers.text(row));
    // The address names the case, so that it can be passed on.
    if (scroll !== null && location.hash !== `#case-${row.number}`) history.replaceState(null, '', `#case-${row.number}`);
    show();
    if (scroll) $('inspector').scrollIntoView({behavior: matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth'});
}
// Any two pictures of the case's scene and level. Two that a row compares have their difference in float; of others it is
// computed from the shown pictures, in linear light.
async function compareChosen() {
    const at = view.at, one = cases.find(c => c.at === at).row, [x, y] = ['a', 'b'].map(side => parts.picks[side].value);
    const known = cases.find(({row}) => (row.image_a === x && row.image_b === y) || (row.image_a === y && row.image_b === x));
    const [a, b] = await Promise.all([pixels(inlined.images[x]), pixels(inlined.images[y])]);
    const d = known ? await differences(known.row.number) : differenceOfPixels(a, b);
    if (view.at !== at || parts.picks.a.value !== x || parts.picks.b.value !== y) return;
    const labels = new Map(handlers.pictures(one));
    loaded = {row: {...one, a: labels.get(x), b: labels.get(y)}, a, b, d, rough: !known};
    show();
}
// #case-12, or #case-12-flip to begin with; scrolls there.
function followHash() {
    const wanted = /^#case-(\d+)(?:-(side|flip|part|difference))?$/.exec(location.hash);
    const found = wanted ? cases.find(c => c.row.number === Number(wanted[1])) : null;
    if (wanted && wanted[2]) view.mode = wanted[2];
    if (found) inspect(found.at, true);
    return Boolean(found);
}
