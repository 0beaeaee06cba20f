// SPDX-License-Identifier: MIT
// planes.js - planes of a level's grid as pictures: one pixel per voxel, without interpolation.

// The grid's axis next to each axis of the world, each once, and its direction: by the largest cosines.
const gridAxes = g => {
    const columns = [0, 1, 2].map(a => normalize(column(g.index_to_world, a)));
    const orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    const fit = order => order.reduce((sum, a, world) => sum + Math.abs(columns[a][world]), 0);
    const order = orders.reduce((best, o) => fit(o) > fit(best) + 1e-9 ? o : best);
    return order.map((axis, world) => ({axis, isReversed: columns[axis][world] < 0}));
};
// Axes of the world to the right, upwards, and through each plane; ends of these axes.
const planeAxes = [[0, 1, 2], [0, 2, 1], [1, 2, 0]];
const planeNames = isPatient => isPatient ? ['axial', 'coronal', 'sagittal'] : ['xy', 'xz', 'yz'];
const endsOf = isPatient => isPatient ? ['LR', 'PA', 'IS'] : [['-x', '+x'], ['-y', '+y'], ['-z', '+z']];

// A plane of a level: `across` and `up` are axes of the grid, reversed if their voxel 0 is at the right or at the top.
const planeOf = (g, worldAxes, isMirrored) => {
    const axes = gridAxes(g), [across, up, through] = worldAxes.map(w => axes[w]);
    return {
        g, across: across.axis, up: up.axis, through: through.axis, fromRight: across.isReversed !== isMirrored,
        fromTop: up.isReversed, width: g.size[across.axis], height: g.size[up.axis],
    };
};
// A point of the picture, 0 to 1 to the right and downwards, in index coordinates, and back.
const indexAt = (plane, [x, y], index) => {
    const at = [...index];
    at[plane.across] = plane.width * (plane.fromRight ? 1 - x : x);
    at[plane.up] = plane.height * (plane.fromTop ? y : 1 - y);
    return at;
};
const placeOf = (plane, index) => {
    const [x, y] = [index[plane.across] / plane.width, index[plane.up] / plane.height];
    return [plane.fromRight ? 1 - x : x, plane.fromTop ? y : 1 - y];
};

const isInside = (g, index) => index.every((x, a) => x >= 0 && x < g.size[a]);
const voxelAt = (g, index) => index.map((x, a) => clamp(Math.floor(x), 0, g.size[a] - 1));
const valueOfNumber = ({scalar}, number) => scalar.zero + scalar.step * number;
// Voxels without data stand below all values (contents.c).
const hasData = (level, value) => value >= level.min - level.scalar.step;
const voxelValue = (level, [x, y, z]) => {
    const value = valueOfNumber(level, level.numbers[x + level.size[0] * (y + level.size[1] * z)]);
    return hasData(level, value) ? value : NaN;
};

// Range without the extreme hundredths.
const usualWindow = level => level.window ??= (() => {
    const {numbers, min, max} = level, stride = Math.max(1, Math.floor(numbers.length / 2e4)), values = [];
    for (let i = 0; i < numbers.length; i += stride) values.push(valueOfNumber(level, numbers[i]));
    const seen = values.filter(v => hasData(level, v)).sort((a, b) => a - b);
    const [lo, hi] = [0.01, 0.99].map(part => seen[Math.floor(part * (seen.length - 1))]);
    return hi > lo ? [lo, hi] : [min, max > min ? max : min + 1];
})();

// Colors and opacities of a transfer function over a level's range: one entry per integer.
const colorsOf = (tf, level, valueRange) => {
    const {min, max, scalar} = level, isWhole = scalar.kind === 'integer', count = isWhole ? max - min + 1 : 1024;
    const step = isWhole ? 1 : (max - min) / (count - 1) || 1, rgba = new Float32Array(4 * count);
    for (let i = 0; i < count; ++i) {
        const [r, g, b, opacity] = samplePoints(tf.points, pointValue(tf, min + i * step, valueRange));
        rgba.set([...[r, g, b].map(c => 255 * clamp(toDisplay(c), 0, 1)), opacity], 4 * i);
    }
    return {rgba, min, step, last: count - 1};
};

// Paints a layer on the pixels of a plane: of another grid it takes the voxel at each pixel's center. With a window it
// replaces pixels by gray; its colors cover them.
const paintLayer = (pixels, plane, index, {level, window, colors, cover}) => {
    const center = (c, r) => indexAt(plane, [(c + 0.5) / plane.width, (r + 0.5) / plane.height], index);
    const at = (c, r) => toIndex(level, toWorld(plane.g, center(c, r)));
    const first = at(0, 0), right = subtract(at(1, 0), first), down = subtract(at(0, 1), first);
    const {numbers, size: [nx, ny, nz]} = level, [lo, hi] = window ?? [0, 1];
    for (let r = 0, pixel = 0; r < plane.height; ++r)
        for (let c = 0; c < plane.width; ++c, pixel += 4) {
            const x = Math.floor(first[0] + c * right[0] + r * down[0]), y = Math.floor(first[1] + c * right[1] + r * down[1]);
            const z = Math.floor(first[2] + c * right[2] + r * down[2]);
            if (x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz) continue;
            const value = valueOfNumber(level, numbers[x + nx * (y + ny * z)]);
            if (!hasData(level, value)) continue;
            if (window) pixels.fill(255 * (value - lo) / (hi - lo), pixel, pixel + 3);
            if (!colors) continue;
            const entry = 4 * clamp(Math.round((value - colors.min) / colors.step), 0, colors.last);
            for (let k = 0; k < 3; ++k)
                pixels[pixel + k] += cover * colors.rgba[entry + 3] * (colors.rgba[entry + k] - pixels[pixel + k]);
        }
};
