// SPDX-License-Identifier: MIT
// adapt.js - adapts a transfer function to a level, with the joint histogram of the page: tf/adapt.h with its defaults
// (means of opacity, flat weight within 1.75 deviations), so `render --adapt --always` shows the same.
const adaptWindow = 1.75;

const makeAdapter = (words, joint) => {
    const rows = joint.s.count, entries = joint.entries, starts = new Uint32Array(rows + 1), weights = new Float32Array(entries);
    for (let i = 0; i < rows; ++i) starts[i + 1] = starts[i] + words[i];
    const zs = words.subarray(rows, rows + entries), counts = words.subarray(rows + entries);
    for (let row = 0; row < rows; ++row) {
        let count = 0, mean = 0, square = 0, sum = 0;
        for (let i = starts[row]; i < starts[row + 1]; ++i) { count += counts[i]; mean += counts[i] * zs[i]; }
        mean /= count;
        for (let i = starts[row]; i < starts[row + 1]; ++i) square += counts[i] * (zs[i] - mean) ** 2;
        const deviation = Math.max(Math.sqrt(square / count), 0.5);
        for (let i = starts[row]; i < starts[row + 1]; ++i)
            if (Math.abs((zs[i] - mean) / deviation) <= adaptWindow) { sum += counts[i] / count; weights[i] = counts[i] / count; }
        for (let i = starts[row]; i < starts[row + 1]; ++i) weights[i] /= sum;
    }
    return {...joint, rows, starts, zs, weights};
};

const adaptTable = (adapter, table, mm) => {
    const {rows, starts, zs, weights, z, s} = adapter, entries = new Float32Array(4 * rows), fine = [];
    for (let i = 0; i < z.count; ++i) {
        const [r, g, b, extinction] = lookUp(table, z.lo + i * z.step), opacity = -Math.expm1(-extinction * mm);
        fine.push([r, g, b, extinction, opacity]);
    }
    const filled = [];
    for (let row = 0; row < rows; ++row) {
        const sum = [0, 0, 0, 0], plain = [0, 0, 0];
        let largest = 0;
        for (let i = starts[row]; i < starts[row + 1]; ++i) {
            const t = fine[zs[i]], w = weights[i];
            if (w === 0) continue;
            for (let c = 0; c < 3; ++c) { sum[c] += w * t[4] * t[c]; plain[c] += w * t[c]; }
            sum[3] += w * t[4];
            largest = Math.max(largest, t[3]);
        }
        if (starts[row] === starts[row + 1]) continue;
        filled.push(row);
        const extinction = sum[3] < 1 ? -Math.log1p(-sum[3]) / mm : largest;
        for (let c = 0; c < 3; ++c) entries[4 * row + c] = sum[3] > 0 ? sum[c] / sum[3] : plain[c];
        entries[4 * row + 3] = Math.min(extinction, largest);
    }
    if (filled.length === 0) return table;
    fillRows(entries, rows, filled, mm);
    return {lo: s.lo, hi: s.lo + s.step * (rows - 1), count: rows, entries};
};

// Rows without fine voxels: interpolated between two filled ones on premultiplied entries, or copied beyond the
// outermost.
const fillRows = (entries, rows, filled, mm) => {
    const at = row => entries.subarray(4 * row, 4 * row + 4), first = filled[0], last = filled[filled.length - 1];
    for (let row = 0; row < first; ++row) at(row).set(at(first));
    for (let row = last + 1; row < rows; ++row) at(row).set(at(last));
    for (let n = 1; n < filled.length; ++n) {
        const [left, right] = [filled[n - 1], filled[n]], l = at(left), r = at(right);
        const al = -Math.expm1(-l[3] * mm), ar = -Math.expm1(-r[3] * mm);
        for (let row = left + 1; row < right; ++row) {
            const f = (row - left) / (right - left), opacity = (1 - f) * al + f * ar, e = at(row);
            for (let c = 0; c < 3; ++c) e[c] = opacity > 0 ? ((1 - f) * al * l[c] + f * ar * r[c]) / opacity : (1 - f) * l[c] + f * r[c];
            e[3] = Math.min(opacity < 1 ? -Math.log1p(-opacity) / mm : Infinity, Math.max(l[3], r[3]));
        }
    }
};
