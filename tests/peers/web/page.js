// SPDX-License-Identifier: MIT
// What the pages of all libraries share.
const arrays = {float32: Float32Array, uint8: Uint8Array, uint16: Uint16Array, int16: Int16Array};

export const samplesOf = ({url, offset, type, sizes}) => new Promise((yes, no) => {
    const asked = new XMLHttpRequest(); // fetch() reads no files
    asked.open('GET', url);
    asked.responseType = 'arraybuffer';
    asked.onerror = () => no(new Error(`${url} cannot be read`));
    asked.onload = () => yes(new arrays[type](asked.response.slice(offset), 0, sizes.reduce((a, b) => a * b)));
    asked.send();
});

export const base64 = bytes => {
    const text = [];
    for (let i = 0; i < bytes.length; i += 8192)
        text.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
    return btoa(text.join(''));
};

// Numbers in [0, 1) that are the same in each run (mulberry32): libraries jitter their rays by Math.random().
export const seedRandom = seed => {
    let state = seed >>> 0;
    Math.random = () => {
        state = (state + 0x6d2b79f5) >>> 0;
        let t = Math.imul(state ^ (state >>> 15), 1 | state);
        t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
        return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
    };
};

// A framebuffer of floats in the place of the canvas, for the experiment that takes its 8 bits away.
export const floatCanvas = (gl, width, height) => {
    if (!gl.getExtension('EXT_color_buffer_float') || !gl.getExtension('EXT_float_blend'))
        throw new Error('this browser draws no floats');
    const own = gl.createFramebuffer(), color = gl.createTexture(), bind = gl.bindFramebuffer.bind(gl);
    gl.bindTexture(gl.TEXTURE_2D, color);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.bindFramebuffer = (target, framebuffer) => bind(target, framebuffer ?? own);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, color, 0);
};

export const readBack = (gl, width, height, floats) => {
    const pixels = floats ? new Float32Array(4 * width * height) : new Uint8Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.readPixels(0, 0, width, height, gl.RGBA, floats ? gl.FLOAT : gl.UNSIGNED_BYTE, pixels);
    return {floats, base64: base64(new Uint8Array(pixels.buffer))};
};
