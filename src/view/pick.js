// SPDX-License-Identifier: MIT
// pick.js - the point under a pixel, at which the ray's opacity passes a half: by midpoints of the picture's own step.

// The ray through a point of the picture, 0 to 1 to the right and downwards, in world coordinates.
const rayThrough = (camera, aspect, [x, y]) => {
    const {forward, right, up} = axesOf(camera);
    const offset = madd(scale(right, (2 * x - 1) * camera.half * aspect), up, (1 - 2 * y) * camera.half);
    return camera.orthographic ? {from: add(camera.position, offset), along: forward}
        : {from: camera.position, along: normalize(add(forward, offset))};
};
// Distances between which the ray is in the box and on the kept side of all clip planes.
const spanOf = (level, clips, from, along) => {
    let near = 0, far = Infinity;
    const cut = (above, rate) => { // stays where above + rate t >= 0
        if (rate > 0) near = Math.max(near, -above / rate);
        else if (rate < 0) far = Math.min(far, -above / rate);
        else if (above < 0) far = -Infinity;
    };
    for (let a = 0; a < 3; ++a) {
        cut(from[a], along[a]);
        cut(level.box_index[a] - from[a], -along[a]);
    }
    for (const [x, y, z, w] of clips) cut(dot([x, y, z], from) - w, dot([x, y, z], along));
    return [near, far];
};
const numberAt = (level, index) => {
    const {numbers, size: [nx, ny, nz], size} = level;
    if (level.labels) {
        const [x, y, z] = voxelAt(level, index);
        return numbers[x + nx * (y + ny * z)];
    }
    const q = index.map((v, a) => clamp(v - 0.5, 0, size[a] - 1)), [x, y, z] = q.map(Math.floor);
    const [fx, fy, fz] = q.map(v => v - Math.floor(v)), mix = (a, b, f) => (1 - f) * a + f * b;
    const row = (j, k) => {
        const at = nx * (Math.min(j, ny - 1) + ny * Math.min(k, nz - 1));
        return mix(numbers[at + x], numbers[at + Math.min(x + 1, nx - 1)], fx);
    };
    return mix(mix(row(y, z), row(y + 1, z), fy), mix(row(y, z + 1), row(y + 1, z + 1), fy), fz);
};

// Null if the ray stays more transparent. q: a request with its camera.
const pickedPoint = (q, level, table, geometry0, aspect, place) => {
    const {from, along} = rayThrough(q.camera, aspect, place), index = toIndex(level, from);
    const perMm = subtract(toIndex(level, add(from, along)), index), step = q.step * Math.min(...spacings(level));
    const [near, far] = spanOf(level, q.clips.map(c => clipInIndex(c, geometry0, level)), index, perMm);
    let left = Math.LN2;
    for (let k = Math.floor(near / step); k * step < far; ++k) {
        const start = Math.max(k * step, near), end = Math.min((k + 1) * step, far);
        const value = valueOfNumber(level, numberAt(level, madd(index, perMm, (start + end) / 2)));
        const extinction = lookUp(table, value)[3], depth = extinction * (end - start);
        if (depth >= left) return madd(from, along, start + left / extinction);
        left -= depth;
    }
    return null;
};
