// SPDX-License-Identifier: MIT
// arrays.js - decodes the page's arrays: from base64 text to numbers, as written by pack.h.
const fromBase64 = text => {
    if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
    const binary = atob(text), bytes = new Uint8Array(binary.length);
    for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
    return bytes;
};
const inflate = async bytes =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'))).arrayBuffer());

// Combines bytes of each weight to numbers, component after component; then sums differences up.
const numbersOf = (packed, d) => {
    const {count, components, bytes: width} = d;
    const numbers = new [Uint8Array, Uint16Array, , Uint32Array][width - 1](count * components);
    for (let c = 0, plane = 0; c < components; ++c) {
        for (let weight = 0; weight < width; ++weight, plane += count)
            if (weight === 0) for (let i = 0, at = c; i < count; ++i, at += components) numbers[at] = packed[plane + i];
            else for (let i = 0, at = c; i < count; ++i, at += components) numbers[at] += packed[plane + i] * 2 ** (8 * weight);
        if (d.delta) for (let i = 1, at = c + components; i < count; ++i, at += components) numbers[at] += numbers[at - components];
    }
    return numbers;
};

// Reads an array's element and drops its text, which would otherwise stay in memory; the browser may keep the blob on
// disk until the page is saved.
const readArray = async d => {
    const element = document.getElementById(d.array), packed = await inflate(fromBase64(element.textContent));
    d.text = new Blob([element.textContent]);
    element.remove();
    if (packed.length !== d.count * d.components * d.bytes) throw new Error(`${d.array}: ${packed.length} bytes, expected ${d.count * d.components * d.bytes}`);
    const numbers = numbersOf(packed, d);
    return d.kind === 'float' ? new Float32Array(numbers.buffer) : numbers;
};
const megabytes = bytes => bytes >= 995e4 ? `${Math.round(bytes / 1e6)} MB` : bytes >= 995e2 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.max(1, Math.round(bytes / 1e3))} kB`;
