// SPDX-License-Identifier: MIT
// textures.js - a level's numbers as textures, and the conversion of texels to values and lattice vectors.
const halves = (() => { // half floats of integers up to 2048, all exact
    const table = new Uint16Array(2049);
    for (let n = 1; n <= 2048; ++n) {
        const exponent = Math.floor(Math.log2(n));
        table[n] = (exponent + 15) << 10 | (n / 2 ** exponent - 1) * 1024;
    }
    return table;
})();
const halfOf = n => n < 0 ? halves[-n] | 0x8000 : halves[n];
// The half floats of numbers [from, to); of -128 that of -127, as of signed bytes in textures. A loop takes a fifth of the time of Uint16Array.from().
const halvesOf = (numbers, from, to) => {
    const out = new Uint16Array(to - from);
    for (let i = from; i < to; ++i) out[i - from] = halfOf(Math.max(numbers[i], -127));
    return out;
};

// In slabs, each a step of a generator, so that the page may pause between them.
const fillSlabs = function* (gl, texture, size, channels, format, type, make) {
    const plane = size[0] * size[1] * channels, planes = Math.max(1, Math.floor(2 ** 17 / plane));
    for (let z = 0; z < size[2]; z += planes) {
        const n = Math.min(planes, size[2] - z);
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_3D, texture);
        gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, z, size[0], size[1], n, format, type, make(z * plane, (z + n) * plane));
        yield;
    }
};
// Runs all steps at once, or with the page and the graphics card between them.
const allSteps = steps => {
    let step = steps.next();
    while (!step.done) step = steps.next();
    return step.value;
};
const slowSteps = async (steps, context) => {
    let step = steps.next();
    for (; !step.done; step = steps.next()) await context.finished();
    return step.value;
};

const uploadScalar = function* (context, level) {
    const {gl, bits} = context, {scalar, numbers, labels} = level, size = level.texels ?? level.size, most = (level.max - level.min) / scalar.step;
    const finest = Math.max(bits.r16f, bits.r32f ?? 0), out = {byHand: false};
    const slabs = (type, make) => fillSlabs(gl, out.texture, size, 1, gl.RED, type, make);
    if (scalar.kind !== 'float' && most <= 255 && bits.r8 >= finest - 1) {
        out.texture = context.volume(0, gl.R8, size);
        yield* slabs(gl.UNSIGNED_BYTE, (a, b) => numbers instanceof Uint8Array ? numbers.subarray(a, b) : Uint8Array.from(numbers.subarray(a, b)));
        Object.assign(out, {perTexel: 255 * scalar.step, bytes: 1});
    } else if (scalar.kind !== 'float' && most <= 2048) {
        out.texture = context.volume(0, gl.R16F, size);
        yield* slabs(gl.HALF_FLOAT, (a, b) => halvesOf(numbers, a, b));
        Object.assign(out, {perTexel: scalar.step, bytes: 2});
    } else {
        out.texture = context.volume(0, gl.R32F, size);
        yield* slabs(gl.FLOAT, (a, b) => Float32Array.from(numbers.subarray(a, b)));
        Object.assign(out, {perTexel: scalar.step, bytes: 4, byHand: !context.floatFilter});
    }
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_3D, out.texture);
    if (labels || out.byHand) context.filter(gl.NEAREST);
    if (labels) out.byHand = false;
    out.bytes *= numbers.length;
    return out;
};

const uploadCodes = function* (context, level, code) {
    const {gl, bits} = context, size = level.texels ?? level.size, bytes = code.numbers, signed = code.signed ? new Int8Array(bytes.buffer) : null;
    const slabs = (texture, type, make) => fillSlabs(gl, texture, size, 3, gl.RGB, type, make);
    if ((signed ? bits.r8snorm : bits.r8) >= bits.r16f - 1) {
        const texture = context.volume(2, signed ? gl.RGB8_SNORM : gl.RGB8, size);
        yield* slabs(texture, signed ? gl.BYTE : gl.UNSIGNED_BYTE, (a, b) => (signed || bytes).subarray(a, b));
        return {texture, scale: signed ? 1 : 2, offset: signed ? 0 : -1, bytes: bytes.length};
    }
    const texture = context.volume(2, gl.RGB16F, size);
    yield* slabs(texture, gl.HALF_FLOAT, (a, b) => halvesOf(signed || bytes, a, b));
    return {texture, scale: signed ? 1 / 127 : 2 / 255, offset: signed ? 0 : -1, bytes: 2 * bytes.length};
};

// Bytes as they are: scaleBytes has their meaning.
const scaleBytes = {one: 168, perOctave: 28}; // ISO_EXTINCTION_SCALE_...
const uploadShare = (context, level) => {
    const {gl} = context, texture = context.volume(8, gl.R16F, level.size);
    const made = (a, b) => halvesOf(level.share.numbers, a, b);
    allSteps(fillSlabs(gl, texture, level.size, 1, gl.RED, gl.HALF_FLOAT, made));
    return texture;
};

const uploadVectors = (context, level) => {
    const {gl} = context, texture = context.volume(2, gl.RGB32F, level.size);
    allSteps(fillSlabs(gl, texture, level.size, 3, gl.RGB, gl.FLOAT, (a, b) => level.vectors.subarray(a, b)));
    if (!context.floatFilter) context.filter(gl.NEAREST);
    return texture;
};
const uploadTable = (context, table, old) => {
    const {gl} = context, texture = old || gl.createTexture();
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, table.count, 1, 0, gl.RGBA, gl.FLOAT, table.entries);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
};
const uploadOccupancy = (context, occupancy, old) => {
    const {gl} = context, texture = old || context.volume(3, gl.R8UI, occupancy.count);
    gl.activeTexture(gl.TEXTURE3);
    gl.bindTexture(gl.TEXTURE_3D, texture);
    context.filter(gl.NEAREST);
    gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, ...occupancy.count, gl.RED_INTEGER, gl.UNSIGNED_BYTE, occupancy.distance);
    return texture;
};
