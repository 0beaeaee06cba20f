// SPDX-License-Identifier: MIT
// Paints pictures of differences: 16 bits on a log scale in red and green.
const decodes = new Map();
function loadImage(uri) {
    return new Promise((resolve, reject) => {
        const image = new Image();
        image.onload = () => resolve(image);
        image.onerror = reject;
        image.src = uri;
    });
}
async function pixels(uri) {
    if (!decodes.has(uri)) decodes.set(uri, (async () => {
        const image = await loadImage(uri);
        const canvas = el('canvas', {width: image.width, height: image.height});
        const context = canvas.getContext('2d', {willReadFrequently: true});
        context.drawImage(image, 0, 0);
        return {canvas, width: image.width, height: image.height, bytes: context.getImageData(0, 0, image.width, image.height).data};
    })());
    return decodes.get(uri);
}
// log10 of the difference; -Infinity for none, Infinity for pixels that are not finite.
async function differences(key, pictures = inlined.differences) {
    const p = await pixels(pictures[key]);
    const logs = new Float32Array(p.width * p.height);
    for (let i = 0; i < logs.length; ++i) {
        const code = p.bytes[4 * i] * 256 + p.bytes[4 * i + 1];
        logs[i] = code === 0 ? -Infinity : code === 65535 ? Infinity : (code - 1) * 11 / 65533 - 9;
    }
    return {logs, width: p.width, height: p.height};
}
const linear = new Float32Array(256).map((x, i) => i / 255 <= 0.04045 ? i / 255 / 12.92 : ((i / 255 + 0.055) / 1.055) ** 2.4);
// The difference of two decoded pictures of one size, from their bytes.
function differenceOfPixels(a, b) {
    const logs = new Float32Array(a.width * a.height);
    for (let i = 0; i < logs.length; ++i) {
        let most = 0;
        for (let c = 0; c < 3; ++c) most = Math.max(most, Math.abs(linear[a.bytes[4 * i + c]] - linear[b.bytes[4 * i + c]]));
        logs[i] = Math.log10(most);
    }
    return {logs, width: a.width, height: a.height};
}
const stops = [[0, 8, 8, 24], [0.25, 72, 20, 110], [0.5, 176, 44, 104], [0.75, 244, 126, 60], [1, 252, 246, 190]];
const shades = 1024, colors = new Uint8ClampedArray(3 * (shades + 1));
for (let i = 0; i <= shades; ++i) {
    const t = i / shades;
    let k = 1;
    while (k < stops.length - 1 && t > stops[k][0]) ++k;
    const [t0, ...a] = stops[k - 1], [t1, ...b] = stops[k], f = (t - t0) / (t1 - t0);
    a.forEach((v, c) => { colors[3 * i + c] = v + f * (b[c] - v); });
}
const shadeOf = t => 3 * Math.round(Math.min(Math.max(t, 0), 1) * shades);
const scaleLow = -8, scaleHigh = 0; // one scale for all cases, so that they can be compared
// Above the threshold in color; below it the image itself, gray and faint.
function paintDifference(d, under, threshold) {
    const canvas = el('canvas', {width: d.width, height: d.height}), context = canvas.getContext('2d');
    const out = context.createImageData(d.width, d.height);
    let above = 0;
    for (let i = 0, o = 0; i < d.logs.length; ++i, o += 4) {
        const log = d.logs[i];
        if (log === Infinity) out.data.set([0, 255, 255], o);
        else if (log > threshold) {
            const at = shadeOf((log - scaleLow) / (scaleHigh - scaleLow));
            for (let c = 0; c < 3; ++c) out.data[o + c] = colors[at + c];
        } else if (under) out.data.fill(0.12 * (under.bytes[o] + under.bytes[o + 1] + under.bytes[o + 2]) / 3, o, o + 3);
        out.data[o + 3] = 255;
        above += log > threshold;
    }
    context.putImageData(out, 0, 0);
    return {canvas, above};
}
function legend() {
    const width = 320, canvas = el('canvas', {width, height: 12, style: 'height:12px;width:320px', 'aria-hidden': 'true'});
    const context = canvas.getContext('2d');
    for (let x = 0; x < width; ++x) {
        context.fillStyle = `rgb(${colors.slice(shadeOf(x / (width - 1)), shadeOf(x / (width - 1)) + 3)})`;
        context.fillRect(x, 0, 1, 12);
    }
    const ticks = el('div', {style: 'display:flex;justify-content:space-between;width:320px;font:11px/1.4 var(--sans);color:var(--quiet)'});
    for (let e = scaleLow; e <= scaleHigh; e += 2) ticks.append(el('span', {}, e === 0 ? '1' : el('span', {}, '10', el('sup', {}, String(e).replace('-', '−')))));
    return el('div', {}, canvas, ticks);
}
