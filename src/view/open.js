// SPDX-License-Identifier: MIT
// open.js - opens a NRRD or NIfTI-1 file that is dropped on the page as its volume: one level, shaded by gradients on
// the fly. Other files need `isoshade view`.

// Like form_of() of contents.c: integers of 16 bits unchanged, others as floats over the range. NaN is no data.
const standInRanges = 2 ** 20; // ISO_STAND_IN_DEVICE
const levelOfVolume = ({type, geometry, values, value_unit}) => {
    let min = Infinity, max = -Infinity, bad = 0, gaps = 0;
    for (const v of values) {
        if (Number.isNaN(v)) ++gaps;
        else if (!Number.isFinite(v)) ++bad;
        if (v < min) min = v;
        if (v > max) max = v;
    }
    if (bad > 0) throw new Error(`${bad} of ${values.length} voxels are infinite, none may be`);
    if (gaps === values.length) throw new Error('no voxel has data');
    const small = /^u?int(8|16)$/.test(type) && max - min <= 65535, range = max - min || 1;
    const numbers = new (!small ? Float32Array : max - min <= 255 ? Uint8Array : Uint16Array)(values.length);
    for (let i = 0; i < values.length; ++i)
        numbers[i] = Number.isNaN(values[i]) ? -standInRanges : (values[i] - min) / (small ? 1 : range);
    const scalar = {kind: small ? 'integer' : 'float', zero: min, step: small ? 1 : range, packed: 0};
    const about = {value_unit, has_no_data: gaps > 0, level: 0, min, max, labels: false, codes: []};
    return {...geometry, ...about, numbers, scalar};
};

// One time step of a file, as a level. The bytes of the last file are kept for its other steps.
let kept = {};
const readVolume = async (file, step, most) => {
    if (file.size === 0) throw new Error('the file is empty');
    const key = [file.name, file.size, file.lastModified].join();
    if (kept.key !== key) {
        const packed = new Uint8Array(await file.arrayBuffer());
        kept = {key, bytes: packed[0] === 0x1f && packed[1] === 0x8b ? await gunzip(packed) : packed};
    }
    const {bytes} = kept, isNrrd = String.fromCharCode(...bytes.subarray(0, 4)) === 'NRRD';
    const volume = isNrrd ? await parseNrrd(bytes) : parseNifti(bytes, step), level = levelOfVolume(volume);
    if (level.size.some(n => !(n > 0 && n <= most))) throw new Error(`a volume of ${level.size.join(' x ')}, limit of this browser's textures: ${most} per side`);
    const ranges = brickRanges(level.numbers, level.size), steps = volume.steps ?? 1;
    return {...level, steps, ranges, window: usualWindow(level)};
};
const openFile = async (worker, file, most) => {
    const level = await worker.run('open', file, 0, most);
    level.readStep = step => worker.run('open', file, step, most);
    return level;
};

// Maps the transfer function of the old volume to the range of the new one.
const laidOnRange = (tf, oldRange, oldSpacing) => {
    const [lo, hi] = tfRange(tf, oldRange), {unit_distance_mm: mm, ...rest} = tf;
    const points = tf.points.map(p => ({...p, value: tf.range === 'fit' ? p.value : clamp((p.value - lo) / (hi - lo), 0, 1)}));
    return {...rest, range: 'fit', points, unit_distance_voxels: mm ? mm / oldSpacing : tf.unit_distance_voxels};
};

// Replaces the page's volume. The camera frames it; transfer functions keep their position in the range.
const replaceVolume = (data, state, level, name) => {
    const columns = [0, 1, 2].map(a => column(level.index_to_world, a)), spacing = Math.cbrt(Math.abs(dot(columns[0], cross(columns[1], columns[2]))));
    const laid = tf => laidOnRange(tf, data.value_range, data.mean_spacing_mm), presets = data.presets.map(p => ({...p, tf: laid(p.tf)}));
    state.tf = laid(state.tf);
    // isoshade may treat integers as labels, which are not interpolated.
    const {is_patient, has_no_data, min, max, value_unit} = level;
    Object.assign(data, {
        title: name, input: quoted(name) + ' --no-labels' + (level.steps > 1 ? ' --frame 0' : ''), levels: [level], codes: [], presets, geometry: level, geometry0: level,
        segments: null, is_patient, has_no_data, value_unit, value_range: [min, max], mean_spacing_mm: spacing,
    });
    const plain = {level: 0, code: null, adapted: false};
    Object.assign(state, {...plain, b: plain, compare: 'none', clips: [], roi: null, tfName: 'scene', edited: null});
    Object.assign(state, {cross: boxCenter(level), window: null, measure: null, colors: false});
    state.sceneAspect = Math.min(1, state.sceneAspect);
    state.camera = lookingFrom(state.camera, level, viewpoints[0][1], viewpoints[0][2], state.sceneAspect);
    data.scene = {...data.scene, image: {width: state.sceneAspect, height: 1}, camera: {...cameraJson(state.camera)}, clip_planes: [], tf: state.tf};
};

// Shows another time step. The transfer function keeps its values.
const changeStep = async (data, state, caster, step) => {
    const [level] = data.levels, {numbers, scalar, min, max, has_no_data, ranges, window} = await level.readStep(step);
    caster.forget(data.levels);
    Object.assign(level, {numbers, scalar, min, max, window, ranges, shownStep: step});
    Object.assign(data, {has_no_data, input: data.input.replace(/( --frame \d+)?$/, ` --frame ${step}`)});
};

const takeFile = async (file, opened) => {
    if (!file) return;
    say(`reading ${file.name}`);
    try { await opened(file); say(''); } catch (problem) { say(`${file.name}: ${problem.message}`); }
};
// Files may be dropped anywhere: a file that missed the picture would replace the page with all edits.
const acceptFiles = (frame, chooser, opened) => {
    const hasFiles = e => e.dataTransfer.types.includes('Files');
    document.addEventListener('dragover', e => { if (hasFiles(e)) { e.preventDefault(); frame.classList.add('drop'); } });
    document.addEventListener('dragleave', e => { if (!e.relatedTarget) frame.classList.remove('drop'); });
    document.addEventListener('drop', e => {
        if (!hasFiles(e)) return;
        e.preventDefault();
        frame.classList.remove('drop');
        takeFile(e.dataTransfer.files[0], opened);
    });
    chooser.addEventListener('change', async () => {
        await takeFile(chooser.files[0], opened);
        chooser.value = ''; // allows to choose the same file again
    });
};
