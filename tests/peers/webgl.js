// SPDX-License-Identifier: MIT
// webgl.js - the page's caster as a renderer of the contract: one request, its pictures in floats. webgl.py makes the page
// around it.
const bytesOf = id => fromBase64(document.getElementById(id).textContent);
const floatsOf = id => new Float32Array(bytesOf(id).buffer);

const makeRequest = async () => {
    const request = JSON.parse(document.getElementById('request').textContent), {volume, camera, tf} = request, values = floatsOf('volume');
    const context = await makeContext(document.createElement('canvas'));
    if (!context || !context.floatTarget) throw new Error('this browser has no WebGL2 with targets of floats');
    let min = Infinity, max = -Infinity;
    for (const v of values) { if (v < min) min = v; if (v > max) max = v; }
    const range = max - min || 1, level = {
        level: 0, size: volume.size, box_index: volume.box_index[1], index_to_world: volume.index_to_world.map(row => row.slice(0, 3)), origin_mm: volume.index_to_world.map(row => row[3]),
        min, max, labels: volume.interpolation === 'nearest', codes: [], numbers: values.map(v => (v - min) / range), scalar: {kind: 'float', zero: min, step: range},
        vectors: request.directions ? floatsOf('directions') : null,
    };
    const entries = new Float32Array(tf.extinction_per_mm.flatMap((sigma, i) => [...tf.color[i], sigma]));
    const data = {levels: [level], geometry0: level}, caster = makeCaster(context, data);
    const q = {
        level, table: {lo: tf.lo, hi: tf.hi, count: tf.extinction_per_mm.length, entries}, vectors: Boolean(level.vectors), code: null,
        camera: {orthographic: camera.projection === 'orthographic', position: camera.position, lookAt: add(camera.position, camera.forward), up: camera.up, half: camera.half_height},
        lights: level.vectors ? request.lights : [], shading: request.shading, background: request.background,
        clips: request.clip_planes.map(c => ({normal: c.normal, point_mm: scale(c.normal, c.offset_mm)})), roi: null,
    };
    const least = Math.min(...spacings(level)), {width, height} = request.image, target = context.target(width, height);
    return i => {
        caster.draw({...q, step: request.frames[i].step_mm / least}, target);
        const bytes = new Uint8Array(context.read(target).buffer);
        let text = '';
        for (let at = 0; at < bytes.length; at += 4096) text += String.fromCharCode(...bytes.subarray(at, at + 4096));
        return btoa(text);
    };
};
window.isoshade = {makeRequest};
