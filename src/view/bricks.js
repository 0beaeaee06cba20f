// SPDX-License-Identifier: MIT
// bricks.js - level 0 of a plan: bricks of several levels in one texture, and the position of each (brick/pack.h).
const planLevel = -1; // its level number in the page: finer than all other levels

// The plan as a level that raycast.glsl draws with BRICKS. Its numbers are the texture's.
const levelOfPlan = (plan, geometry0) => ({...geometry0, ...plan, level: planLevel, isPlan: true, labels: false, brickCount: plan.bricks});

// Range of values of each brick; empty for bricks that are left out.
const rangesOfBricks = (level, layout) => {
    const {brickCount: count, brick_voxels: side, texels, numbers} = level, total = count[0] * count[1] * count[2];
    const least = new Float32Array(total).fill(Infinity), most = new Float32Array(total).fill(-Infinity);
    for (let brick = 0; brick < total; ++brick) {
        const [x0, y0, z0, held] = layout.subarray(4 * brick, 4 * brick + 4);
        if (!held) continue;
        const n = side / 2 ** (held - 1) + 1;
        let lo = Infinity, hi = -Infinity;
        for (let z = z0; z < z0 + n; ++z)
            for (let y = y0; y < y0 + n; ++y)
                for (let i = x0 + texels[0] * (y + texels[1] * z), end = i + n; i < end; ++i) {
                    if (numbers[i] < lo) lo = numbers[i];
                    if (numbers[i] > hi) hi = numbers[i];
                }
        least[brick] = lo;
        most[brick] = hi;
    }
    return {count, least, most};
};

const uploadLayout = (context, level) => {
    const {gl} = context, {brickCount: count, texels, layout} = level, places = new Float32Array(layout.numbers.length);
    for (let i = 0; i < places.length; i += 4) {
        const held = layout.numbers[i + 3];
        for (let a = 0; a < 3; ++a) places[i + a] = (layout.numbers[i + a] + 0.5) / texels[a];
        places[i + 3] = held ? 2 ** (1 - held) : 0;
    }
    const texture = context.volume(7, gl.RGBA32F, count);
    context.filter(gl.NEAREST);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, ...count, gl.RGBA, gl.FLOAT, places);
    return texture;
};

const readPlan = async (level, read) => {
    const {numbers} = await read(level.scalar), code = level.codes[0];
    code.numbers = (await read(code)).numbers;
    level.layout.numbers = (await read(level.layout)).numbers;
    level.numbers = numbers;
    level.ranges = rangesOfBricks(level, level.layout.numbers);
};

const planCost = level => {
    const digits = x => x === null ? 'by an unknown value' : `by RMSE ${Number(x.toPrecision(2))}`;
    return `${level.drawn} of ${level.brickCount.reduce((a, b) => a * b)} bricks of level 0 (${level.name}). In the planned views, with their transfer function, pictures differ from level 0's ${digits(level.predicted_rmse)} (predicted) and ${digits(level.measured_rmse)} (measured); in other views bricks may be missing or coarse.`;
};
