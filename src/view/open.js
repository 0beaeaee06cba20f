// SPDX-License-Identifier: MIT
// open.js - a NRRD or NIfTI-1 file that is dropped on the picture becomes the page's volume: one level, shaded by gradients
// on the fly. What the files say is read as volume/nrrd_open.c and nifti_open.c read it; other files need `isoshade view`.
const gunzip = async bytes => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).arrayBuffer());

const readers = { // bytes of a sample, and how a DataView reads it
    int8: [1, 'getInt8'], uint8: [1, 'getUint8'], int16: [2, 'getInt16'], uint16: [2, 'getUint16'], int32: [4, 'getInt32'], uint32: [4, 'getUint32'],
    float: [4, 'getFloat32'], double: [8, 'getFloat64'],
};
const nrrdTypes = {
    'signed char': 'int8', int8: 'int8', int8_t: 'int8', uchar: 'uint8', 'unsigned char': 'uint8', uint8: 'uint8', uint8_t: 'uint8',
    short: 'int16', 'short int': 'int16', 'signed short': 'int16', int16: 'int16', int16_t: 'int16', ushort: 'uint16', 'unsigned short': 'uint16', uint16: 'uint16',
    uint16_t: 'uint16', int: 'int32', 'signed int': 'int32', int32: 'int32', int32_t: 'int32', uint: 'uint32', 'unsigned int': 'uint32', uint32: 'uint32',
    uint32_t: 'uint32', float: 'float', double: 'double',
};
const decodeSamples = (bytes, offset, count, type, little, slope = 1, intercept = 0) => {
    const [width, get] = readers[type];
    if (bytes.length - offset < count * width) throw new Error(`the file ends after ${bytes.length} bytes, ${offset + count * width} are needed`);
    const view = new DataView(bytes.buffer, bytes.byteOffset + offset, count * width), values = new Float32Array(count);
    for (let i = 0; i < count; ++i) values[i] = slope * view[get](i * width, little) + intercept;
    return values;
};
// Centers of voxels to outer corners: voxel i has its center at i + 1/2.
const geometryOf = (size, columns, center) => ({
    size, box_index: size, index_to_world: transpose(columns), origin_mm: columns.reduce((o, c) => madd(o, c, -0.5), center),
});

const parseNrrd = async bytes => {
    let end = 0;
    while (end < bytes.length && !(bytes[end] === 10 && (bytes[end + 1] === 10 || (bytes[end + 1] === 13 && bytes[end + 2] === 10)))) ++end;
    const text = new TextDecoder().decode(bytes.subarray(0, end)), start = end + (bytes[end + 1] === 13 ? 3 : 2), field = {};
    for (const line of text.split(/\r?\n/).slice(1)) { const m = /^([^:=#]+): ?(.*)$/.exec(line); if (m) field[m[1].trim().toLowerCase()] = m[2].trim(); }
    if (field['data file'] || field.datafile) throw new Error('the NRRD header names another file for its samples; isoshade view reads it');
    const size = (field.sizes || '').split(/\s+/).map(Number), type = nrrdTypes[field.type];
    if (size.length !== 3 || !type) throw new Error(`a NRRD file of ${size.length} axes and type ${field.type}; the page reads scalars of three axes`);
    const vectors = [...(field['space directions'] || '').matchAll(/\(([^)]*)\)/g)].map(m => m[1].split(',').map(Number));
    const steps = (field.spacings || '1 1 1').split(/\s+/).map(s => Number(s) || 1);
    const signs = /left-posterior|^lps/i.test(field.space || '') ? [-1, -1, 1] : /left-anterior|^las/i.test(field.space || '') ? [-1, 1, 1] : [1, 1, 1];
    const columns = vectors.length === 3 ? vectors.map(v => v.map((x, i) => x * signs[i])) : [0, 1, 2].map(a => [0, 1, 2].map(i => i === a ? steps[a] : 0));
    const given = /\(([^)]*)\)/.exec(field['space origin'] || ''), origin = given ? given[1].split(',').map((x, i) => Number(x) * signs[i]) : null;
    const middle = columns.reduce((m, c, a) => madd(m, c, -(size[a] - 1) / 2), [0, 0, 0]);
    let samples = bytes.subarray(start);
    const encoding = (field.encoding || 'raw').toLowerCase();
    if (encoding === 'gzip' || encoding === 'gz') samples = await gunzip(samples);
    else if (encoding !== 'raw') throw new Error(`a NRRD file in ${encoding}; the page reads raw and gzip`);
    const little = (field.endian || 'little') === 'little';
    return {type, geometry: geometryOf(size, columns, origin || middle), values: decodeSamples(samples, 0, size[0] * size[1] * size[2], type, little)};
};

const niftiTypes = {2: 'uint8', 4: 'int16', 8: 'int32', 16: 'float', 64: 'double', 256: 'int8', 512: 'uint16', 768: 'uint32'};
const parseNifti = async packed => {
    const bytes = packed[0] === 0x1f && packed[1] === 0x8b ? await gunzip(packed) : packed, view = new DataView(bytes.buffer, bytes.byteOffset);
    const little = view.getInt32(0, true) === 348, short = o => view.getInt16(o, little), float = o => view.getFloat32(o, little);
    if (!little && view.getInt32(0, false) !== 348) throw new Error('neither NRRD nor NIfTI-1; isoshade view reads other formats');
    const size = [42, 44, 46].map(short), type = niftiTypes[short(70)], pixdim = [76, 80, 84, 88].map(float);
    if (!type || short(40) > 3 && short(48) > 1) throw new Error('a NIfTI file of colors or of several volumes; the page reads one scalar volume');
    let columns = [0, 1, 2].map(a => [0, 1, 2].map(i => i === a ? pixdim[a + 1] || 1 : 0)), center = columns.reduce((m, c, a) => madd(m, c, -(size[a] - 1) / 2), [0, 0, 0]);
    if (short(254) > 0) {
        const rows = [280, 296, 312].map(o => [0, 4, 8, 12].map(k => float(o + k)));
        columns = [0, 1, 2].map(a => rows.map(r => r[a]));
        center = rows.map(r => r[3]);
    } else if (short(252) > 0) {
        const [b, c, d] = [256, 260, 264].map(float), a = Math.sqrt(Math.max(0, 1 - b * b - c * c - d * d)), flip = pixdim[0] < 0 ? -1 : 1;
        const m = [[a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)], [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)], [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - c * c - b * b]];
        columns = [0, 1, 2].map(k => scale(column(m, k), pixdim[k + 1] * (k === 2 ? flip : 1)));
        center = [268, 272, 276].map(float);
    }
    const slope = float(112), scaled = Number.isFinite(slope) && slope !== 0;
    return {type: scaled && (slope !== 1 || float(116) % 1 !== 0) ? 'float' : type, geometry: geometryOf(size, columns, center),
        values: decodeSamples(bytes, Math.round(float(108)), size[0] * size[1] * size[2], type, little, scaled ? slope : 1, scaled ? float(116) : 0)};
};

// As form_of() of contents.c: integers of 16 bits as they are, all else in floats over the range.
const levelOfVolume = ({type, geometry, values}) => {
    let min = Infinity, max = -Infinity;
    for (let i = 0; i < values.length; ++i) { if (values[i] < min) min = values[i]; if (values[i] > max) max = values[i]; }
    if (!Number.isFinite(max - min)) throw new Error('the volume has values that are no numbers');
    const small = /^u?int(8|16)$/.test(type) && max - min <= 65535, range = max - min || 1;
    const numbers = small ? new (max - min <= 255 ? Uint8Array : Uint16Array)(values.length) : values;
    for (let i = 0; i < values.length; ++i) numbers[i] = small ? Math.round(values[i] - min) : (values[i] - min) / range;
    return {...geometry, level: 0, min, max, labels: false, codes: [], numbers, scalar: {kind: small ? 'integer' : 'float', zero: min, step: small ? 1 : range, packed: 0}};
};

const openFile = async (file, most) => {
    const bytes = new Uint8Array(await file.arrayBuffer()), isNrrd = bytes[0] === 78 && bytes[1] === 82 && bytes[2] === 82 && bytes[3] === 68;
    const level = levelOfVolume(await (isNrrd ? parseNrrd : parseNifti)(bytes));
    if (level.size.some(n => !(n > 0 && n <= most))) throw new Error(`a volume of ${level.size.join(' x ')}, this browser's textures have at most ${most} a side`);
    return level;
};

// The page's volume is another one from now on. The camera frames it; a transfer function of fixed values is laid on its range.
const replaceVolume = (data, state, level, name) => {
    const range = [level.min, level.max], [lo, hi] = tfRange(state.tf, data.value_range);
    const points = state.tf.points.map(p => ({...p, value: state.tf.range === 'fit' ? p.value : clamp((p.value - lo) / (hi - lo), 0, 1)}));
    const {unit_distance_mm: mm, ...tf} = state.tf, spacing = Math.cbrt(Math.abs(dot(column(level.index_to_world, 0), cross(column(level.index_to_world, 1), column(level.index_to_world, 2)))));
    state.tf = {...tf, range: 'fit', points, unit_distance_voxels: mm ? mm / data.mean_spacing_mm : tf.unit_distance_voxels};
    Object.assign(data, {title: name, levels: [level], codes: [], presets: [], geometry: level, geometry0: level, value_range: range, mean_spacing_mm: spacing, opened: true});
    Object.assign(state, {level: 0, code: null, adapted: false, compare: 'none', clips: [], roi: null, tfName: 'scene', b: {level: 0, code: null, adapted: false}});
    state.camera = lookingFrom(state.camera, level, viewpoints[0][1], viewpoints[0][2], state.sceneAspect);
    data.scene = {...data.scene, camera: {...cameraJson(state.camera)}, clip_planes: [], tf: state.tf};
};

const acceptFiles = (target, opened, say) => {
    const take = async file => {
        if (!file) return;
        say(`reading ${file.name}`);
        try { await opened(file); say(''); } catch (problem) { say(`${file.name}: ${problem.message}`); }
    };
    target.addEventListener('dragover', e => { e.preventDefault(); target.classList.add('drop'); });
    target.addEventListener('dragleave', () => target.classList.remove('drop'));
    target.addEventListener('drop', e => { e.preventDefault(); target.classList.remove('drop'); take(e.dataTransfer.files[0]); });
    document.getElementById('open').addEventListener('change', e => take(e.target.files[0]));
};
