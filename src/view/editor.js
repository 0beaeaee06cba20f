// SPDX-License-Identifier: MIT
// editor.js - the editor of transfer functions over the histogram of values: points to drag, their opacity and color.
// Integers of a small range have one bin each.
const histogramOf = (level, [lo, hi]) => {
    const whole = level.scalar.kind === 'integer' && hi - lo < 512, bins = whole ? hi - lo + 1 : 256;
    if (whole) [lo, hi] = [lo - 0.5, hi + 0.5];
    const counts = new Float64Array(bins), {numbers, scalar} = level, factor = bins / ((hi - lo) || 1), stride = Math.floor(numbers.length / 5e5) | 1; // odd: not the same columns only
    for (let i = 0; i < numbers.length; i += stride) {
        const value = valueOfNumber(level, numbers[i]);
        if (hasData(level, value)) ++counts[clamp(Math.floor((value - lo) * factor), 0, bins - 1)];
    }
    const most = Math.log1p(counts.reduce((m, c) => Math.max(m, c), 0));
    return {heights: [...counts].map(c => Math.log1p(c) / most), lo, hi};
};
// Values to the right, gradient magnitudes up: homogeneous materials are spots at the bottom, boundaries are arches
// [kniss-2002]. Drawn as a picture under the curve.
const jointPicture = (level, [lo, hi]) => {
    const {numbers, scalar, size: [nx, ny, nz]} = level, whole = scalar.kind === 'integer' && hi - lo < 256;
    const width = whole ? hi - lo + 1 : 256, height = 48; // rows wider than the gradient steps of integers
    const least = Math.min(...spacings(level)), [sx, sy, sz] = spacings(level).map(s => 0.5 * least / s), column = (width - (whole ? 0 : 1)) / ((hi - lo + (whole ? 1 : 0)) || 1);
    const step = Math.max(1, Math.round(Math.cbrt(nx * ny * nz / 3e5))), columns = [], magnitudes = [];
    for (let z = 1; z < nz - 1; z += step) for (let y = 1; y < ny - 1; y += step) for (let x = 1; x < nx - 1; x += step) {
        const i = x + nx * (y + ny * z);
        const around = [0, 1, -1, nx, -nx, nx * ny, -nx * ny];
        if (level.has_no_data && !around.every(d => hasData(level, valueOfNumber(level, numbers[i + d])))) continue;
        columns.push(clamp(Math.floor((scalar.zero + numbers[i] * scalar.step - lo) * column), 0, width - 1));
        magnitudes.push(Math.hypot((numbers[i + 1] - numbers[i - 1]) * sx, (numbers[i + nx] - numbers[i - nx]) * sy, (numbers[i + nx * ny] - numbers[i - nx * ny]) * sz));
    }
    // Scaled to a gradient that a thousandth of the voxels exceeds: otherwise the few largest would push the rest to
    // the bottom.
    const most = Float32Array.from(magnitudes).sort()[Math.floor(0.999 * magnitudes.length)] || 1, counts = new Float64Array(width * height);
    magnitudes.forEach((g, i) => { ++counts[columns[i] + width * (height - 1 - Math.floor(Math.min(g / most, 1) * (height - 1)))]; });
    const highest = Math.log1p(counts.reduce((m, c) => Math.max(m, c), 0)), canvas = Object.assign(document.createElement('canvas'), {width, height});
    const paint = canvas.getContext('2d'), image = paint.createImageData(width, height);
    counts.forEach((c, i) => image.data.set([128, 128, 128, 255 * Math.log1p(c) / highest], 4 * i));
    paint.putImageData(image, 0, 0);
    return canvas.toDataURL();
};

const makeEditor = (root, data, state, changed) => {
    const svg = root.querySelector('svg'), fields = Object.fromEntries([...root.querySelectorAll('[data-field]')].map(e => [e.dataset.field, e]));
    const make = (name, attributes, parent = svg) => {
        const e = document.createElementNS('http://www.w3.org/2000/svg', name);
        for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
        parent.append(e);
        return e;
    };
    const [width, height, base] = [320, 162, 132];
    let chosen = 0, histogram = null, dragged = null, counted = null, joint = null;
    const domain = () => { const [lo, hi] = tfRange(state.tf, data.value_range), [a, b] = data.value_range; return [Math.min(lo, a), Math.max(hi, b)]; };
    const x = value => { const [lo, hi] = domain(); return 8 + (width - 16) * (value - lo) / ((hi - lo) || 1); };
    const valueAt = px => { const [lo, hi] = domain(); return lo + (px - 8) / (width - 16) * (hi - lo); };
    const y = opacity => base - (base - 10) * opacity;
    const opacityAt = py => clamp((base - py) / (base - 10), 0, 1);
    const points = () => state.tf.points;
    const place = p => [x(valueOf(state.tf, p, data.value_range)), y(p.opacity)];
    const short = v => Number(v.toPrecision(4)).toString();

    // A new list each time: tables are cached by their points.
    const edit = (change, resting = true) => {
        const list = points().map(p => ({...p}));
        change(list);
        list.forEach((p, i) => { p.index = i; });
        const kept = list[chosen];
        list.sort((a, b) => a.value - b.value || a.index - b.index);
        chosen = Math.max(0, list.indexOf(kept));
        list.forEach(p => delete p.index);
        state.tf = fineEnough({...state.tf, points: list}, data.value_range);
        state.tfName = 'edited';
        state.edited = state.tf;
        draw();
        changed(!resting);
    };
    const draw = () => {
        const focused = svg.contains(document.activeElement); // keep the focus on the points, which are made again
        svg.replaceChildren();
        const gradient = make('linearGradient', {id: 'colors'}, make('defs', {})), [lo, hi] = domain();
        for (let i = 0; i <= 64; ++i) {
            const v = lo + i / 64 * (hi - lo), [r, g, b] = samplePoints(points(), pointValue(state.tf, v, data.value_range));
            make('stop', {offset: i / 64, 'stop-color': hexOf({r, g, b})}, gradient);
        }
        if (joint) {
            const from = x(data.value_range[0]);
            make('image', {x: from, y: 10, width: Math.max(0, x(data.value_range[1]) - from), height: base - 10, href: joint, preserveAspectRatio: 'none'});
        } else if (histogram) {
            let d = `M8 ${base}`;
            const {heights, lo: first, hi: end} = histogram;
            heights.forEach((h, i) => { const px = clamp(x(first + (i + 0.5) / heights.length * (end - first)), 8, width - 8); d += `L${px.toFixed(2)} ${(base - h * (base - 10)).toFixed(2)}`; });
            make('path', {d: `${d}L${width - 8} ${base}Z`, class: 'histogram'});
        }
        const line = points().map(p => place(p).map(n => n.toFixed(2)).join(' ')), last = points()[points().length - 1];
        const curve = `M8 ${place(points()[0])[1].toFixed(2)}L${line.join('L')}L${width - 8} ${y(last.opacity).toFixed(2)}`;
        make('path', {d: `${curve}L${width - 8} ${base}L8 ${base}Z`, class: 'area', fill: 'url(#colors)'});
        make('path', {d: curve, class: 'curve'});
        make('rect', {x: 8, y: base + 4, width: width - 16, height: 8, fill: 'url(#colors)', class: 'bar'});
        const title = `value${inUnit(data)}`, below = {y: base + 24, 'aria-hidden': true};
        for (const [at, value, anchor] of [[8, lo, 'start'], [width - 8, hi, 'end']])
            make('text', {...below, x: at, 'text-anchor': anchor}).textContent = short(value);
        make('text', {...below, x: width / 2, 'text-anchor': 'middle'}).textContent = title;
        fields.value.previousSibling.textContent = title;
        points().forEach((p, i) => {
            const [cx, cy] = place(p), value = short(valueOf(state.tf, p, data.value_range)), c = make('circle', {cx, cy, r: 6, fill: hexOf(p), class: 'point', tabindex: 0, 'data-point': i,
                role: 'slider', 'aria-label': `point ${i + 1} of ${points().length}, opacity ${short(p.opacity)}, value`,
                'aria-valuemin': short(lo), 'aria-valuemax': short(hi), 'aria-valuenow': value});
            c.addEventListener('focus', () => { if (chosen !== i) { chosen = i; tell(); mark(); } });
        });
        tell();
        mark();
        if (focused) svg.querySelectorAll('.point')[chosen]?.focus({preventScroll: true});
    };
    // Draws the chosen point above others at its position.
    const mark = () => {
        const [cx, cy] = place(points()[chosen]);
        svg.querySelector('.chosen')?.remove();
        make('circle', {cx, cy, r: 6, fill: hexOf(points()[chosen]), class: 'chosen', 'aria-hidden': true});
    };
    const tell = () => {
        const p = points()[chosen], unit = state.tf.unit_distance_mm ? `${short(state.tf.unit_distance_mm)} mm` : state.tf.unit_distance_voxels === 1 ? 'a voxel' : `${short(state.tf.unit_distance_voxels)} voxels`;
        fields.value.value = short(valueOf(state.tf, p, data.value_range));
        fields.opacity.value = short(p.opacity);
        fields.color.value = hexOf(p);
        fields.remove.disabled = points().length < 2;
        fields.about.textContent = `point ${chosen + 1} of ${points().length}; opacity is over ${unit}`;
    };
    const at = e => { const box = svg.getBoundingClientRect(); return [(e.clientX - box.left) / box.width * width, (e.clientY - box.top) / box.height * height]; };
    const nearest = (px, py, within) => {
        let best = -1, least = within;
        points().forEach((p, i) => { const [cx, cy] = place(p), d = Math.hypot(cx - px, cy - py); if (d < least) [best, least] = [i, d]; });
        return best;
    };
    const put = (list, i, value, opacity) => { list[i].value = pointValue(state.tf, value, data.value_range); list[i].opacity = opacity; };

    svg.addEventListener('pointerdown', e => {
        const [px, py] = at(e), hit = nearest(px, py, 12);
        e.preventDefault();
        svg.setPointerCapture(e.pointerId);
        if (hit >= 0) { chosen = hit; tell(); mark(); }
        dragged = hit >= 0 ? hit : null;
        svg.querySelectorAll('.point')[chosen]?.focus({preventScroll: true});
    });
    svg.addEventListener('pointermove', e => {
        if (dragged === null) return;
        const [px, py] = at(e), [lo, hi] = domain();
        edit(list => put(list, chosen, clamp(valueAt(px), lo, hi), opacityAt(py)), false);
    });
    for (const end of ['pointerup', 'pointercancel']) svg.addEventListener(end, () => { if (dragged !== null) changed(false); dragged = null; });
    const insert = value => edit(list => {
        const [r, g, b, opacity] = samplePoints(list, pointValue(state.tf, value, data.value_range));
        list.push({value: pointValue(state.tf, value, data.value_range), r, g, b, opacity});
        chosen = list.length - 1;
    });
    svg.addEventListener('dblclick', e => { const [px, py] = at(e); if (nearest(px, py, 12) < 0) insert(clamp(valueAt(px), ...domain())); });
    svg.addEventListener('keydown', e => {
        const [lo, hi] = domain(), fine = e.shiftKey ? 0.2 : 1, p = points()[chosen];
        const [dx, dy] = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[e.key] || [0, 0];
        if (dx || dy) edit(list => put(list, chosen, clamp(valueOf(state.tf, p, data.value_range) + fine * dx * (hi - lo) / 100, lo, hi), clamp(p.opacity + fine * dy * 0.02, 0, 1)));
        else if ((e.key === 'Delete' || e.key === 'Backspace') && points().length > 1) edit(list => list.splice(chosen, 1));
        else if (e.key === 'Insert' || e.key === 'Enter') insert((valueOf(state.tf, p, data.value_range) + hi) / 2);
        else return;
        e.preventDefault();
        svg.querySelectorAll('.point')[chosen]?.focus();
    });
    // Invalid numbers change nothing; the field shows the old value again.
    const typed = (field, [lo, hi], take) => field.addEventListener('change', () => {
        const text = field.value.trim(), number = Number(text);
        if (text === '' || Number.isNaN(number)) tell();
        else edit(list => take(list, clamp(number, lo(), hi())));
    });
    typed(fields.value, [() => domain()[0], () => domain()[1]], (list, value) => put(list, chosen, value, list[chosen].opacity));
    typed(fields.opacity, [() => 0, () => 1], (list, opacity) => { list[chosen].opacity = opacity; });
    fields.color.addEventListener('input', () => edit(list => Object.assign(list[chosen], linearOfHex(fields.color.value)), false));
    fields.color.addEventListener('change', () => changed(false));
    fields.add.addEventListener('click', () => {
        const list = points(), here = valueOf(state.tf, list[chosen], data.value_range), next = list[chosen + 1], [, hi] = domain();
        insert((here + (next ? valueOf(state.tf, next, data.value_range) : hi)) / 2);
    });
    fields.remove.addEventListener('click', () => { if (points().length > 1) edit(list => list.splice(chosen, 1)); });
    const showJoint = () => { joint = fields.joint.checked && counted ? jointPicture(counted, data.value_range) : null; draw(); };
    fields.joint.addEventListener('change', showJoint);
    return {
        draw, count: level => { counted = level; histogram = histogramOf(level, data.value_range); showJoint(); },
        take: (tf, name) => { state.tf = linearTf(tf); state.tfName = name; chosen = Math.min(chosen, points().length - 1); draw(); changed(false); },
    };
};
