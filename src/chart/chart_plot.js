// SPDX-License-Identifier: MIT
// The plot of a chart: both axes are logarithmic, a setting is a shape, a front is a staircase.
const svg = (tag, attributes, ...children) => {
    const e = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [key, value] of Object.entries(attributes || {})) if (value !== null && value !== undefined) e.setAttribute(key, value);
    e.append(...children.flat());
    return e;
};
// Colors that people with color blindness can distinguish (Okabe and Ito), ordered for light and dark themes.
const palette = ['#0072b2', '#d55e00', '#009e73', '#e69f00', '#cc79a7', '#56b4e9', '#8f8f8f', '#8c564b', '#8a9a00', '#7a6fd0'];
const shapes = [
    s => `M${-s} 0a${s} ${s} 0 1 0 ${2 * s} 0a${s} ${s} 0 1 0 ${-2 * s} 0`, s => `M${-s} ${-s}h${2 * s}v${2 * s}h${-2 * s}z`,
    s => `M0 ${-1.2 * s}L${1.15 * s} ${0.9 * s}H${-1.15 * s}z`, s => `M0 ${-1.3 * s}L${1.3 * s} 0L0 ${1.3 * s}L${-1.3 * s} 0z`,
    s => `M0 ${1.2 * s}L${1.15 * s} ${-0.9 * s}H${-1.15 * s}z`,
];
const styleOf = i => ({color: palette[i % palette.length], shape: shapes[i % shapes.length]});
const shown = (x, unit) => unit === 'ms' ? `${Number(x.toPrecision(3))} ms`
    : x >= 1e9 ? `${Number((x / 1e9).toPrecision(3))} GB` : x >= 1e6 ? `${Number((x / 1e6).toPrecision(3))} MB` : x >= 1e3 ? `${Number((x / 1e3).toPrecision(3))} kB` : `${x} B`;

// An axis over the values: place(x) from 0 to 1, and ticks at 1, 2 and 5 of each decade, or at decades if there are
// many.
function axisOf(values, margin) {
    const good = values.filter(v => v > 0 && Number.isFinite(v)), lo = Math.log10(Math.min(...good)), hi = Math.log10(Math.max(...good));
    const wide = Math.max(hi - lo, 0.3), from = (lo + hi) / 2 - wide / 2 - margin * wide, to = (lo + hi) / 2 + wide / 2 + margin * wide;
    const ticks = [];
    for (let d = Math.floor(from); d <= Math.ceil(to); ++d)
        for (const m of to - from < 2.4 ? [1, 2, 5] : [1]) {
            const at = d + Math.log10(m);
            if (at >= from && at <= to) ticks.push([(at - from) / (to - from), m * 10 ** d]);
        }
    return {place: x => (Math.log10(x) - from) / (to - from), ticks};
}

// A staircase along the points of a front: no point beyond it is as good.
function staircase(points) {
    const sorted = [...points].sort((a, b) => a.x - b.x);
    return sorted.map((p, i) => i ? `H${p.x.toFixed(1)}V${p.y.toFixed(1)}` : `M${p.x.toFixed(1)} ${p.y.toFixed(1)}`).join('');
}

// {points: [{at, cost, error, style, size, front, own, ring, number, renderer}], unit, xTitle, yTitle, want} -> {element, places}
function drawPlot(chart) {
    const wide = chart.wide, high = Math.min(470, Math.round(wide * 1.1)), left = 74, right = 18, top = 12, bottom = 50, w = wide - left - right, h = high - top - bottom;
    const points = chart.points.filter(p => p.cost > 0 && p.error > 0), errors = points.map(p => p.error);
    const x = axisOf(points.map(p => p.cost), 0.05), y = axisOf(chart.want > 0 ? [...errors, chart.want] : errors, 0.05);
    for (const p of points) { p.x = left + w * x.place(p.cost); p.y = top + h * (1 - y.place(p.error)); }
    const parts = [];
    const apart = Math.ceil(x.ticks.length / (w / 58)); // skip labels that would touch
    const half = 27; // half the widest label, so that the last one stays inside
    for (const [i, [at, value]] of x.ticks.entries()) parts.push(svg('line', {class: 'grid', x1: left + w * at, x2: left + w * at, y1: top, y2: top + h}),
        svg('text', {class: 'tick', x: Math.min(left + w * at, wide - half), y: top + h + 18, 'text-anchor': 'middle'}, i % apart ? '' : shown(value, chart.unit)));
    for (const [at, value] of y.ticks) parts.push(svg('line', {class: 'grid', x1: left, x2: left + w, y1: top + h * (1 - at), y2: top + h * (1 - at)}),
        svg('text', {class: 'tick', x: left - 8, y: top + h * (1 - at) + 4, 'text-anchor': 'end'}, value >= 0.001 ? String(Number(value.toPrecision(2))) : value.toExponential(0)));
    parts.push(svg('path', {class: 'axis', fill: 'none', d: `M${left} ${top}V${top + h}H${left + w}`}),
        svg('text', {x: left + w / 2, y: high - 8, 'text-anchor': 'middle'}, chart.xTitle),
        svg('text', {x: 0, y: 0, transform: `translate(16 ${top + h / 2}) rotate(-90)`, 'text-anchor': 'middle'}, chart.yTitle));
    if (chart.want > 0) { const at = top + h * (1 - y.place(chart.want)); parts.push(svg('line', {class: 'want', x1: left, x2: left + w, y1: at, y2: at})); }
    if (chart.byRenderer)
        for (const [name, color] of chart.byRenderer) parts.push(svg('path', {class: 'own', stroke: color, 'data-renderer': name, d: staircase(points.filter(p => p.own && p.renderer === name))}));
    else parts.push(svg('path', {class: 'front', d: staircase(points.filter(p => p.front))}));
    const marks = svg('g', {});
    for (const p of [...points].sort((a, b) => (a.front || a.own) - (b.front || b.own))) {
        marks.append(svg('path', {class: p.front || p.own ? 'point' : 'point off', 'data-case': p.at, fill: p.style.color, transform: `translate(${p.x.toFixed(1)} ${p.y.toFixed(1)})`, d: p.style.shape(p.size)}));
        if (p.ring) marks.append(svg('circle', {class: 'ring', cx: p.x, cy: p.y, r: 10}));
    }
    let last = null;
    for (const p of points.filter(q => q.number).sort((a, b) => a.y - b.y)) { // skip numbers that would overlap
        if (last && Math.abs(last.x - p.x) < 22 && p.y - last.y < 12) continue;
        marks.append(svg('text', {class: 'number', x: p.x - 9, y: p.y - 6, 'text-anchor': 'end'}, String(p.number)));
        last = p;
    }
    const at = svg('circle', {class: 'at', r: 12, visibility: 'hidden'});
    const element = svg('svg', {viewBox: `0 0 ${wide} ${high}`, tabindex: 0, role: 'application', 'aria-label': `${chart.yTitle} against ${chart.xTitle}, ${points.length} settings. Left and right move through all settings, up and down along the front.`}, ...parts, marks, at);
    return {element, points, wide, mark: p => { at.setAttribute('visibility', p ? 'visible' : 'hidden'); if (p) { at.setAttribute('cx', p.x); at.setAttribute('cy', p.y); } }};
}
