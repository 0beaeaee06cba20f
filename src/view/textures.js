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

// In slabs, without a second copy of the volume.
const fillSlabs = (gl, size, channels, format, type, make) => {
    const plane = size[0] * size[1] * channels, planes = Math.max(1, Math.floor(2 ** 22 / plane));
    for (let z = 0; z < size[2]; z += planes) {
        const n = Math.min(planes, size[2] - z);
        gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, z, size[0], size[1], n, format, type, make(z * plane, (z + n) * plane));
    }
};

const uploadScalar = (context, level) => {
    const {gl, bits} = context, {scalar, numbers, labels} = level, size = level.texels ?? level.size, most = (level.max - level.min) / scalar.step;
    const finest = Math.max(bits.r16f, bits.r32f ?? 0), slabs = (type, make) => fillSlabs(gl, size, 1, gl.RED, type, make);
    const out = {byHand: false};
    if (scalar.kind !== 'float' && most <= 255 && bits.r8 >= finest - 1) {
        out.texture = context.volume(0, gl.R8, size);
        slabs(gl.UNSIGNED_BYTE, (a, b) => numbers instanceof Uint8Array ? numbers.subarray(a, b) : Uint8Array.from(numbers.subarray(a, b)));
        Object.assign(out, {perTexel: 255 * scalar.step, bytes: 1});
    } else if (scalar.kind !== 'float' && most <= 2048) {
        out.texture = context.volume(0, gl.R16F, size);
        slabs(gl.HALF_FLOAT, (a, b) => Uint16Array.from(numbers.subarray(a, b), n => halves[n]));
        Object.assign(out, {perTexel: scalar.step, bytes: 2});
    } else {
        out.texture = context.volume(0, gl.R32F, size);
        slabs(gl.FLOAT, (a, b) => Float32Array.from(numbers.subarray(a, b)));
        Object.assign(out, {perTexel: scalar.step, bytes: 4, byHand: !context.floatFilter});
    }
    if (labels || out.byHand) context.filter(gl.NEAREST);
    if (labels) out.byHand = false;
    out.bytes *= numbers.length;
    return out;
};

const uploadCodes = (context, level, code) => {
    const {gl, bits} = context, size = level.texels ?? level.size, bytes = code.numbers, signed = code.signed ? new Int8Array(bytes.buffer) : null;
    const slabs = (type, make) => fillSlabs(gl, size, 3, gl.RGB, type, make);
    if ((signed ? bits.r8snorm : bits.r8) >= bits.r16f - 1) {
        const texture = context.volume(2, signed ? gl.RGB8_SNORM : gl.RGB8, size);
        slabs(signed ? gl.BYTE : gl.UNSIGNED_BYTE, (a, b) => (signed || bytes).subarray(a, b));
        return {texture, scale: signed ? 1 : 2, offset: signed ? 0 : -1, bytes: bytes.length};
    }
    const texture = context.volume(2, gl.RGB16F, size);
    slabs(gl.HALF_FLOAT, (a, b) => Uint16Array.from((signed || bytes).subarray(a, b), n => halfOf(signed ? Math.max(n, -127) : n)));
    return {texture, scale: signed ? 1 / 127 : 2 / 255, offset: signed ? 0 : -1, bytes: 2 * bytes.length};
};

const uploadVectors = (context, level) => {
    const {gl} = context, texture = context.volume(2, gl.RGB32F, level.size);
    fillSlabs(gl, level.size, 3, gl.RGB, gl.FLOAT, (a, b) => level.vectors.subarray(a, b));
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
