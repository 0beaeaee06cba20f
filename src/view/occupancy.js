// SPDX-License-Identifier: MIT
// occupancy.js - finds the bricks that a transfer function shows, and the distance of each brick to them:
// brick/occupancy.c.
const brickVoxels = 8, skipOccupied = 0.5;

// Range of numbers of each brick, extended by half a voxel.
const brickRanges = (numbers, size) => {
    const count = size.map(n => Math.ceil(n / brickVoxels)), total = count[0] * count[1] * count[2];
    const least = new Float32Array(total), most = new Float32Array(total);
    const from = (b, a) => Math.max(b * brickVoxels - 1, 0), to = (b, a) => Math.min((b + 1) * brickVoxels + 1, size[a]);
    for (let bz = 0, brick = 0; bz < count[2]; ++bz)
        for (let by = 0; by < count[1]; ++by)
            for (let bx = 0; bx < count[0]; ++bx, ++brick) {
                let lo = Infinity, hi = -Infinity;
                for (let z = from(bz), z1 = to(bz, 2); z < z1; ++z)
                    for (let y = from(by), y1 = to(by, 1); y < y1; ++y) {
                        const row = size[0] * (y + size[1] * z);
                        for (let i = row + from(bx), end = row + to(bx, 0); i < end; ++i) {
                            const n = numbers[i];
                            if (n < lo) lo = n;
                            if (n > hi) hi = n;
                        }
                    }
                least[brick] = lo;
                most[brick] = hi;
            }
    return {count, least, most};
};

// True if a table shows values of a range. Wider by a thousandth of an entry, because textures are looked up in float.
const shownBy = table => {
    const last = table.count - 1, perValue = last / (table.hi - table.lo), before = new Uint32Array(table.count + 1);
    for (let i = 0; i <= last; ++i) before[i + 1] = before[i] + (table.entries[4 * i + 3] > 0);
    return (min, max) => {
        const first = clamp((min - table.lo) * perValue - 1e-3, 0, last), end = clamp((max - table.lo) * perValue + 1e-3, 0, last);
        return before[Math.ceil(end) + 1] > before[Math.floor(first)];
    };
};

// Chessboard distances: a forward and a backward sweep over the neighbors visited before.
const sweep = (count, distance, direction) => {
    const [nx, ny, nz] = count, n = nx * ny * nz;
    for (let j = 0; j < n; ++j) {
        const i = direction > 0 ? j : n - 1 - j, x = i % nx, y = Math.floor(i / nx) % ny, z = Math.floor(i / (nx * ny));
        let least = distance[i];
        for (let o = 0; o < 13 && least > 0; ++o) {
            const qx = x + direction * (o % 3 - 1), qy = y + direction * (Math.floor(o / 3) % 3 - 1), qz = z + direction * (Math.floor(o / 9) - 1);
            if (qx < 0 || qy < 0 || qz < 0 || qx >= nx || qy >= ny || qz >= nz) continue;
            least = Math.min(least, distance[qx + nx * (qy + ny * qz)] + 1);
        }
        distance[i] = least;
    }
};
const occupancyOf = (ranges, form, table) => {
    const distance = new Uint8Array(ranges.least.length), isShown = shownBy(table);
    let occupied = 0;
    for (let i = 0; i < distance.length; ++i) {
        const [least, most] = [ranges.least[i], ranges.most[i]];
        const shows = least <= most && isShown(form.zero + least * form.step, form.zero + most * form.step);
        distance[i] = shows ? 0 : 255;
        occupied += shows;
    }
    sweep(ranges.count, distance, 1);
    sweep(ranges.count, distance, -1);
    return {distance, count: ranges.count, part: occupied / distance.length};
};
