// SPDX-License-Identifier: MIT
// transfer.js - transfer functions of a tf.json: the table for textures (tf.c), display colors, edits.
const toLinear = s => s <= 0.04045 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4;
const toDisplay = l => l <= 0.0031308 ? 12.92 * l : 1.055 * l ** (1 / 2.4) - 0.055;
const hexOf = p => '#' + [p.r, p.g, p.b].map(c => Math.round(255 * clamp(toDisplay(c), 0, 1)).toString(16).padStart(2, '0')).join('');
const linearOfHex = hex => { const [r, g, b] = [1, 3, 5].map(i => toLinear(parseInt(hex.slice(i, i + 2), 16) / 255)); return {r, g, b}; };
const linearTf = tf => tf.color_space !== 'srgb' ? tf
    : {...tf, color_space: 'linear', points: tf.points.map(p => ({...p, r: toLinear(p.r), g: toLinear(p.g), b: toLinear(p.b)}))};

// Color and opacity of the points at a value: linear between points, constant beyond.
const samplePoints = (points, value) => {
    let above = 0;
    while (above < points.length && points[above].value <= value) ++above;
    const lo = points[Math.max(above - 1, 0)], hi = points[Math.min(above, points.length - 1)], span = hi.value - lo.value;
    const f = span > 0 ? clamp((value - lo.value) / span, 0, 1) : 0;
    return ['r', 'g', 'b', 'opacity'].map(k => (1 - f) * lo[k] + f * hi[k]);
};
const tfRange = (tf, valueRange) => {
    if (tf.range !== 'fit') return tf.range;
    const [lo, hi] = valueRange;
    return [lo, hi > lo ? hi : lo + Math.max(1, Math.abs(lo))];
};
const mostOpacity = 0.9999;
const tabulate = (tf, valueRange, meanSpacing) => {
    const [lo, hi] = tfRange(tf, valueRange), count = tf.table_size ?? 256, entries = new Float32Array(4 * count);
    const unit = tf.unit_distance_mm ?? tf.unit_distance_voxels * meanSpacing;
    for (let i = 0; i < count; ++i) {
        const t = i / (count - 1), s = samplePoints(tf.points, tf.range === 'fit' ? t : lo + t * (hi - lo));
        entries.set([s[0], s[1], s[2], -Math.log1p(-Math.min(s[3], mostOpacity)) / unit], 4 * i);
    }
    return {lo, hi, count, entries};
};
// Ends a table below the least value without opacity, like iso_tf_table_end_below(): voxels without data stand there.
const mostEntries = 16384; // ISO_TF_MOST_ENTRIES
const endedBelow = (t, least) => {
    if (!(t.entries[3] > 0) || t.count >= mostEntries) return t;
    const step = (t.hi - t.lo) / (t.count - 1), room = mostEntries - t.count - 1;
    const more = 1 + clamp(Math.ceil((t.lo - least) / step), 0, room);
    const entries = new Float32Array(4 * (t.count + more)), first = t.entries.subarray(0, 4);
    for (let i = 0; i < more; ++i) entries.set(first, 4 * i);
    entries[3] = 0;
    entries.set(t.entries, 4 * more);
    return {...t, lo: t.lo - step * more, count: t.count + more, entries};
};
const lookUp = (table, value) => {
    const last = table.count - 1, x = clamp((value - table.lo) / (table.hi - table.lo) * last, 0, last);
    const i = Math.min(Math.floor(x), last - 1), f = x - i, e = table.entries;
    return [0, 1, 2, 3].map(c => (1 - f) * e[4 * i + c] + f * e[4 * i + 4 + c]);
};

// Points of a fitted range are fractions; the editor uses values.
const valueOf = (tf, point, valueRange) => { const [lo, hi] = tfRange(tf, valueRange); return tf.range === 'fit' ? lo + point.value * (hi - lo) : point.value; };
const pointValue = (tf, value, valueRange) => { const [lo, hi] = tfRange(tf, valueRange); return tf.range === 'fit' ? (value - lo) / (hi - lo) : value; };

// Refines a table in which a narrow peak would fall between two entries, as tf.c requires.
const fineEnough = (tf, valueRange) => {
    const [lo, hi] = tf.range === 'fit' ? [0, 1] : tfRange(tf, valueRange), values = tf.points.map(p => p.value);
    let nearest = hi - lo;
    for (let i = 1; i < values.length; ++i) if (values[i] > values[i - 1]) nearest = Math.min(nearest, values[i] - values[i - 1]);
    let size = tf.table_size ?? 256;
    while (size < 4096 && (hi - lo) / (size - 1) > nearest / 2) size *= 2;
    return size === (tf.table_size ?? 256) ? tf : {...tf, table_size: size};
};
