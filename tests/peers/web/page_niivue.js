// SPDX-License-Identifier: MIT
// NiiVue draws a request: volume, transfer function and box go through its public interface, to its own shader. It has
// no camera but azimuth and elevation, so the request's matrices and direction of rays are put in their place. Pictures
// over black and over white give colors and opacity, as a page shows them.
import {NVImage, Niivue, SLICE_TYPE} from '@niivue/niivue';

import {base64, readBack, samplesOf} from './page.js';

let request, nv, gl;
const entries = 256; // of NiiVue's color maps
const codes = {uint8: [2, 8], int16: [4, 16], float32: [16, 32], uint16: [512, 16]}; // NIfTI's datatype and bits

// Products of 4 x 4 matrices by rows.
const times = (a, b) => a.map(row => [0, 1, 2, 3].map(j => row.reduce((sum, x, k) => sum + x * b[k][j], 0)));
const spacings = m => [0, 1, 2].map(a => Math.hypot(...m.map(row => row[a])));
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

// The volume as a NIfTI file whose box begins at the origin, along its axes.
const nifti = ({volume}, type, samples) => {
    const [datatype, bits] = codes[type], lengths = spacings(volume.index_to_world);
    const file = new ArrayBuffer(352 + samples.byteLength), head = new DataView(file);
    head.setInt32(0, 348, true);
    [3, ...volume.size, 1, 1, 1, 1].forEach((n, i) => head.setInt16(40 + 2 * i, n, true));
    head.setInt16(70, datatype, true);
    head.setInt16(72, bits, true);
    [1, ...lengths].forEach((x, i) => head.setFloat32(76 + 4 * i, x, true));
    head.setFloat32(108, 352, true);
    head.setFloat32(112, 1, true);
    head.setInt8(123, 2); // mm
    head.setInt16(254, 1, true); // sform
    lengths.forEach((x, i) => {
        head.setFloat32(280 + 16 * i + 4 * i, x, true);
        head.setFloat32(280 + 16 * i + 12, x / 2, true);
    });
    head.setUint32(344, 0x00312b6e, true);
    new Uint8Array(file).set(new Uint8Array(samples.buffer, samples.byteOffset, samples.byteLength), 352);
    return file;
};

// The direction of all rays: in voxels, and in mm along the volume's axes.
const directions = ({volume, camera}) => {
    const m = volume.index_to_world, lengths = spacings(m);
    const along = [0, 1, 2].map(a => dot(m.map(row => row[a] / lengths[a]), camera.forward)); // orthogonal axes
    return {mm: along, voxels: Math.hypot(...along.map((x, a) => x / lengths[a]))};
};

// A color map has 256 entries of 8 bits; an opacity is that of one of NiiVue's steps, a voxel along the ray.
const colormap = ({lo, hi, color, extinction_per_mm: extinction}, stepMm) => {
    const map = {R: [], G: [], B: [], A: [], I: [], min: lo, max: hi}, last = extinction.length - 1;
    for (let i = 0; i < entries; ++i) {
        const at = i / (entries - 1) * last, k = Math.min(Math.floor(at), Math.max(last - 1, 0)), t = at - k;
        const between = list => list[k] + t * (list[Math.min(k + 1, last)] - list[k]);
        ['R', 'G', 'B'].forEach((c, j) => map[c].push(Math.round(255 * Math.min(between(color.map(x => x[j])), 1))));
        map.A.push(Math.round(-255 * Math.expm1(-between(extinction) * stepMm)));
        map.I.push(i);
    }
    return map;
};

const matrix = ({volume, camera}) => {
    const lengths = spacings(volume.index_to_world);
    const place = [...volume.index_to_world.map(row => row.map((x, i) => i < 3 ? x / lengths[i] : x)), [0, 0, 0, 1]];
    const all = times(camera.projection_matrix, times(camera.view, place));
    return Float32Array.from([0, 1, 2, 3].flatMap(column => all.map(row => row[column])));
};

// Puts the request's camera in the place of NiiVue's. Rays are parallel, also in perspective.
const placeCamera = () => {
    const identity = Float32Array.from([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), mvp = matrix(request);
    const uniform3fv = gl.uniform3fv.bind(gl), rays = directions(request).mm;
    // For an experiment: NiiVue's colors are multiplied by alpha before they are blended by it.
    const blendFunc = gl.blendFunc.bind(gl), once = request.changes.includes('blend-once');
    gl.blendFunc = (from, to) => blendFunc(once && from === gl.SRC_ALPHA ? gl.ONE : from, to);
    nv.calculateMvpMatrix = () => [mvp, identity, identity];
    gl.uniform3fv = (where, value) => uniform3fv(where, where === nv.renderShader.uniforms.rayDir ? rays : value);
};

const refuse = () => {
    const {volume, clip_planes: planes} = request, m = volume.index_to_world, [first, last] = volume.box_index;
    const column = a => m.map(row => row[a]);
    if (planes.length || first.some(x => x > 0) || last.some((x, a) => x < volume.size[a]))
        throw new Error('clip planes are not for this page');
    const isSheared = (a, b) => Math.abs(dot(column(a), column(b))) > 1e-6 * dot(column(a), column(a));
    if (isSheared(0, 1) || isSheared(0, 2) || isSheared(1, 2))
        throw new Error('NiiVue would resample a sheared grid');
};

window.prepare = async asked => {
    request = asked;
    refuse();
    const canvas = document.createElement('canvas'), {width, height} = request.image;
    canvas.width = width;
    canvas.height = height;
    canvas.style.cssText = `display:block;width:${width}px;height:${height}px`;
    document.body.append(canvas);
    nv = new Niivue({isResizeCanvas: false, forceDevicePixelRatio: 1, show3Dcrosshair: false, isOrientCube: false,
        isColorbar: false, isOrientationTextVisible: false, dragAndDropEnabled: false, loadingText: '',
        logLevel: 'error', sliceType: SLICE_TYPE.RENDER});
    await nv.attachToCanvas(canvas, false);
    const {samples, tf} = request;
    nv.addColormap('isoshade', colormap(tf, 1 / directions(request).voxels));
    const file = new Blob([nifti(request, samples.type, await samplesOf(samples))]);
    const image = await NVImage.loadFromUrl({url: URL.createObjectURL(file), name: 'volume.nii', colormap: 'isoshade',
        cal_min: tf.lo, cal_max: tf.hi});
    nv.addVolume(image);
    nv.setInterpolation(request.volume.interpolation === 'nearest');
    await nv.setVolumeRenderIllumination(0);
    gl = nv.gl;
    placeCamera();
};

// The picture over a background.
const over = (value, width, height) => {
    nv.opts.backColor = [value, value, value, 1];
    nv.drawScene();
    return Uint8Array.from(atob(readBack(gl, width, height, false).base64), c => c.charCodeAt(0));
};

window.draw = async () => {
    const {width, height} = request.image, black = over(0, width, height), white = over(1, width, height);
    const pixels = new Float32Array(black.length);
    for (let i = 0; i < pixels.length; i += 4) {
        const clear = (white[i + 1] - black[i + 1]) / 255;
        for (let c = 0; c < 3; ++c)
            pixels[i + c] = black[i + c] / 255 + clear * request.background[c];
        pixels[i + 3] = 1 - clear;
    }
    return {floats: true, base64: base64(new Uint8Array(pixels.buffer))};
};
