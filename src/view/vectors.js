// SPDX-License-Identifier: MIT
// vectors.js - vectors and 3 x 3 matrices (arrays of rows), in double.
const add = (a, b) => a.map((x, i) => x + b[i]);
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const scale = (a, s) => a.map(x => x * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const length = a => Math.sqrt(dot(a, a));
const normalize = a => { const n = length(a); return n > 0 ? scale(a, 1 / n) : [0, 0, 0]; };
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const madd = (a, b, s) => a.map((x, i) => x + b[i] * s);
const column = (m, i) => [m[0][i], m[1][i], m[2][i]];
const transpose = m => [column(m, 0), column(m, 1), column(m, 2)];
const multiply = (m, v) => m.map(row => dot(row, v));
const inverse = m => {
    const columns = [0, 1, 2].map(i => column(m, i)), det = dot(columns[0], cross(columns[1], columns[2]));
    return [cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])].map(r => scale(r, 1 / det));
};
const rotate = (v, axis, angle) => { // Rodrigues
    const c = Math.cos(angle), s = Math.sin(angle), part = dot(axis, v) * (1 - c);
    return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, part));
};
const clamp = (x, lo, hi) => Math.min(Math.max(x, lo), hi);

// Geometry of a level, as in volume/geometry.h.
const toWorld = (g, index) => add(g.origin_mm, multiply(g.index_to_world, index));
const toIndex = (g, world) => multiply(inverse(g.index_to_world), subtract(world, g.origin_mm));
const spacings = g => [0, 1, 2].map(i => length(column(g.index_to_world, i)));
const boxCenter = g => toWorld(g, scale(g.box_index, 0.5));
const boxRadius = g => { // half the longest diagonal
    let most = 0;
    for (const signs of [[1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]])
        most = Math.max(most, length(multiply(g.index_to_world, g.box_index.map((b, i) => b * signs[i]))));
    return most / 2;
};
