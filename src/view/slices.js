// SPDX-License-Identifier: MIT
// slices.js - three planes of the shown level, with a crosshair and lengths, and the values under the cursor.
const svgElement = name => document.createElementNS('http://www.w3.org/2000/svg', name);
// Lines over a picture, of points from 0 to 1 to the right and downwards.
const drawLines = (svg, lines) => {
    const path = svg.firstElementChild ?? svg.appendChild(svgElement('path'));
    const pointText = p => p.map(x => x.toFixed(5)).join(' ');
    path.setAttribute('d', lines.map(ends => `M${ends.map(pointText).join('L')}`).join(''));
};

// The element of one slice; `on` takes its events.
const makeCell = on => {
    const canvas = element('canvas', {tabIndex: 0}), svg = svgElement('svg'), name = element('span', {className: 'name'});
    const letters = ['left', 'right', 'top', 'bottom'].map(end => element('span', {className: `end ${end}`}));
    const plane = element('div', {className: 'plane'}, canvas, svg, ...letters);
    const root = element('div', {className: 'cell slice'}, plane, name);
    const set = (e, attributes) => { for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value); };
    set(svg, {viewBox: '0 0 1 1', preserveAspectRatio: 'none', 'aria-hidden': true});
    set(canvas, {role: 'application', 'aria-roledescription': 'slice'});
    const enlarge = () => root.classList.toggle('large');
    let dragged = null;
    const pointed = e => {
        const box = canvas.getBoundingClientRect();
        return [(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height].map(x => clamp(x, 0, 1 - 1e-9));
    };
    canvas.addEventListener('pointerdown', e => {
        canvas.setPointerCapture(e.pointerId);
        dragged = {at: pointed(e), isWindow: e.button === 2 || e.shiftKey};
        if (!dragged.isWindow) on.press(dragged.at);
    });
    canvas.addEventListener('pointermove', e => {
        const at = pointed(e);
        if (!dragged) on.hover(at);
        else if (dragged.isWindow) on.window(subtract(at, dragged.at));
        else on.drag(at);
        if (dragged) dragged.at = at;
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { dragged = null; });
    canvas.addEventListener('pointerleave', () => on.hover(null));
    canvas.addEventListener('contextmenu', e => e.preventDefault());
    canvas.addEventListener('dblclick', enlarge);
    canvas.addEventListener('wheel', e => {
        e.preventDefault();
        on.step('through', e.deltaY > 0 ? 1 : -1);
    }, {passive: false});
    canvas.addEventListener('keydown', e => {
        const step = {
            ArrowLeft: ['across', -1], ArrowRight: ['across', 1], ArrowUp: ['up', 1], ArrowDown: ['up', -1],
            PageUp: ['through', 1], PageDown: ['through', -1],
        }[e.key];
        if ((!step && e.key !== 'Enter') || e.ctrlKey || e.metaKey || e.altKey) return;
        e.preventDefault();
        if (step) on.step(...step);
        else if (!on.enter()) enlarge();
    });
    return {root, canvas, svg, name, letters, plane};
};

// worker: reads files of at most `most` voxels per side.
const makeSlices = (root, data, state, {caster, frames, worker, most}, moved) => {
    const $ = id => document.getElementById(id);
    let drawn = '', hovered = null;
    const shown = () => { // the level of the picture, or the finest one that is read if that is in bricks
        const {level} = requestOf(data, state, 'a'), whole = data.levels.filter(l => l.numbers && !l.isPlan);
        return level.isPlan ? whole.reduce((best, l) => l.level < best.level ? l : best) : level;
    };
    const windowNow = () => state.window ?? usualWindow(shown());
    const isMirrored = () => Boolean(data.is_patient && !state.neurological);
    const planeNow = n => planeOf(shown(), planeAxes[n], isMirrored());
    const crossIndex = () => toIndex(shown(), state.cross);
    const worldAt = (n, at) => toWorld(shown(), indexAt(planeNow(n), at, crossIndex()));
    // A crosshair stays in the middle of a voxel, so that each step of a key is one.
    const moveTo = index => {
        const g = shown();
        state.cross = toWorld(g, voxelAt(g, index).map(x => x + 0.5));
        hovered = null;
        moved();
    };
    const mark = world => {
        state.measure = state.measure.length === 2 ? [world] : [...state.measure, world];
        moved();
    };

    const valueThere = (level, point) => {
        const index = toIndex(level, point);
        return isInside(level, index) ? voxelValue(level, voxelAt(level, index)) : NaN;
    };
    const about = point => {
        const level = shown(), index = toIndex(level, point), voxel = voxelAt(level, index);
        if (!isInside(level, index)) return '';
        const value = voxelValue(level, voxel), name = data.segments?.find(s => s.label === value)?.name;
        const of = level.level ? ` of level ${level.level}` : '', named = name ? ` ${name}` : '';
        const digits = `${Number(value.toPrecision(7))}${data.value_unit && !named ? ` ${data.value_unit}` : ''}`;
        const text = level.values ?? (Number.isNaN(value) ? 'no data' : digits + named), over = data.overlay;
        const other = over ? ` · ${over.name} ${Number(valueThere(over.level, point).toPrecision(7))}` : '';
        return `voxel ${voxel.join(' ')}${of} · ${point.map(x => x.toFixed(2)).join(', ')} mm · ${text}${other}`;
    };
    const lengthText = () => {
        const points = state.measure;
        if (points?.length === 2) return `length ${length(subtract(points[1], points[0])).toFixed(2)} mm`;
        const wanted = points?.length ? 'the second point' : 'two points', there = state.slices ? 'crosshair' : 'middle';
        return points ? `Click ${wanted}; Enter takes the ${there}.` : '';
    };
    const tell = () => {
        $('readout').textContent = state.slices ? about(hovered ?? state.cross) : lengthText();
        $('length').textContent = lengthText();
    };

    const cells = planeAxes.map((axes, n) => makeCell({
        press: at => state.measure ? mark(worldAt(n, at)) : moveTo(indexAt(planeNow(n), at, crossIndex())),
        drag: at => { if (!state.measure) moveTo(indexAt(planeNow(n), at, crossIndex())); },
        hover: at => {
            hovered = at && worldAt(n, at);
            tell();
        },
        window: ([dx, dy]) => {
            const [lo, hi] = windowNow(), half = (hi - lo) / 2 * Math.exp(2 * dx), middle = (lo + hi) / 2 + dy * (hi - lo);
            state.window = [middle - half, middle + half];
            panel();
            moved();
        },
        step: (direction, by) => {
            const plane = planeNow(n), index = crossIndex();
            const isReversed = {across: plane.fromRight, up: plane.fromTop}[direction];
            index[plane[direction]] += isReversed ? -by : by;
            moveTo(index);
        },
        enter: () => {
            if (state.measure) mark(state.cross);
            return Boolean(state.measure);
        },
    }));
    root.append(...cells.map(c => c.root));

    const layersOf = level => {
        const colors = state.colors ? colorsOf(state.tf, level, data.value_range) : null;
        const own = {level, window: level.labels ? null : windowNow(), colors, cover: 1};
        return data.overlay && state.overlay ? [own, overlayLayer(data.overlay.level, state.overlay)] : [own];
    };
    const drawPlane = (n, level, layers) => {
        const plane = planeNow(n), {canvas, svg, name, letters} = cells[n], {width, height} = plane;
        const index = crossIndex(), voxel = voxelAt(level, index), spacing = spacings(level);
        if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
        const paint = canvas.getContext('2d'), image = paint.createImageData(width, height);
        for (let i = 3; i < image.data.length; i += 4) image.data[i] = 255;
        for (const layer of layers) paintLayer(image.data, plane, voxel.map(x => x + 0.5), layer);
        paint.putImageData(image, 0, 0);
        const ratio = width * spacing[plane.across] / (height * spacing[plane.up]);
        cells[n].plane.style.setProperty('--ratio', ratio);
        const [across, up] = planeAxes[n].map(w => endsOf(data.is_patient)[w]);
        const ends = [...isMirrored() ? [across[1], across[0]] : across, up[1], up[0]];
        ends.forEach((text, i) => { letters[i].textContent = text; });
        name.textContent = `${planeNames(data.is_patient)[n]} ${voxel[plane.through]}`;
        canvas.setAttribute('aria-label', `${name.textContent} of 0 to ${level.size[plane.through] - 1}. `
            + 'Arrows and Page keys move the crosshair, Enter enlarges.');
        const [x, y] = placeOf(plane, index), lines = [[[x, 0], [x, 1]], [[0, y], [1, y]]];
        if (state.measure?.length === 2) lines.push(state.measure.map(p => placeOf(plane, toIndex(level, p))));
        drawLines(svg, lines);
    };
    const draw = () => {
        root.classList.toggle('four', state.slices);
        $('slices').setAttribute('aria-pressed', state.slices);
        $('readout').hidden = !state.slices && !state.measure;
        tell();
        if (!state.slices) return;
        const level = shown(), {cross, measure, neurological, colors, tf, overlay} = state;
        const look = [windowNow(), measure, neurological, colors && tf, data.overlay?.name, overlay];
        const key = JSON.stringify([data.title, level.level, level.shownStep, cross, look]);
        if (key === drawn) return;
        drawn = key;
        if (!state.window) panel();
        const layers = layersOf(level);
        planeAxes.forEach((axes, n) => drawPlane(n, level, layers));
    };

    const check = (text, key) => {
        const box = element('input', {type: 'checkbox', checked: state[key]}), row = labeled(text, box);
        row.className = 'check';
        box.addEventListener('change', () => {
            state[key] = box.checked;
            moved();
        });
        return row;
    };
    // The picture follows, too.
    const openOver = file => takeFile(file, async chosen => {
        const level = await openFile(worker, chosen, most), old = data.overlay;
        await frames.settled();
        if (old) caster.forget([old.level]);
        level.labels = isLabelLevel(level);
        data.overlay = {level, name: chosen.name};
        state.overlay = overlaySettings();
        panel();
        frames.ask();
    });
    const endMeasuring = () => {
        state.measure = null;
        panel();
        moved();
    };
    const panel = () => {
        const [lo, hi] = data.value_range, wide = hi - lo || 1, limits = {min: lo - wide, max: hi + wide, step: 'any'};
        const bound = (text, i) => slider(text, {...limits, value: Number(windowNow()[i].toPrecision(6))}, v => {
            const other = windowNow()[1 - i], least = wide / 1e6;
            state.window = i ? [Math.min(other, v - least), v] : [v, Math.max(other, v + least)];
            moved();
        });
        const text = state.measure ? 'end measuring' : 'measure a length';
        const measure = element('button', {type: 'button', textContent: text});
        measure.addEventListener('click', () => {
            if (state.measure) return endMeasuring();
            state.measure = [];
            panel();
            moved();
        });
        refill($('slicing'), bound(`black${inUnit(data)}`, 0), bound(`white${inUnit(data)}`, 1),
            check('colors of the transfer function', 'colors'),
            ...(data.is_patient ? [check("the patient's right at the right", 'neurological')] : []),
            element('div', {className: 'buttons'}, measure));
        refill($('overlay'), ...overlayPanel(data, state, openOver, frames.ask, panel));
        tell();
    };
    $('slices').onclick = () => {
        state.slices = !state.slices;
        moved();
    };
    // Ends the large slice, or else measuring.
    const leave = () => {
        const large = cells.find(c => c.root.classList.contains('large'));
        if (large) large.root.classList.remove('large');
        else if (state.measure) endMeasuring();
    };
    // Takes the point under a pixel of the picture as an end of a length.
    const pick = (camera, aspect, place) => {
        const q = {...requestOf(data, state, 'a'), camera}, level = shown();
        const table = caster.tableOf(level, q.tf, q.adapted && level.level > 0);
        return pickedPoint(q, level, table, data.geometry0, aspect, place);
    };
    const clicked = (camera, aspect, place) => {
        const point = state.measure && pick(camera, aspect, place);
        if (point) mark(point);
        else if (state.measure) $('readout').textContent = 'not opaque there: the opacity stays below a half';
    };
    return {draw, panel, shown, leave, pick, clicked};
};
