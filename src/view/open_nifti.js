// SPDX-License-Identifier: MIT
// open_nifti.js - reads a NIfTI-1 file's bytes as a volume, like volume/nifti_open.c.
const niftiTypes = {2: 'uint8', 4: 'int16', 8: 'int32', 16: 'float', 64: 'double', 256: 'int8', 512: 'uint16', 768: 'uint32', 1024: 'int64', 1280: 'uint64'};
const niftiHeaderBytes = 348;

// The columns of the rotation of a unit quaternion, of which the file has three parts.
const quaternionColumns = (b, c, d) => {
    const a = Math.sqrt(Math.max(0, 1 - b * b - c * c - d * d));
    return [
        [a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)],
        [2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)],
        [2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b],
    ];
};
// Position of the center of voxel (0, 0, 0), and one step along each axis, in the file's unit.
const niftiAffine = (float, short) => {
    const pixdim = [76, 80, 84, 88].map(float);
    if (short(254) > 0) {
        const rows = [280, 296, 312].map(o => [0, 4, 8, 12].map(k => float(o + k)));
        return {columns: [0, 1, 2].map(a => rows.map(r => r[a])), center: rows.map(r => r[3])};
    }
    if (short(252) > 0) {
        const flip = pixdim[0] < 0 ? -1 : 1, columns = quaternionColumns(...[256, 260, 264].map(float));
        return {columns: columns.map((c, k) => scale(c, checkedSpacing(Math.abs(pixdim[k + 1])) * (k === 2 ? flip : 1))), center: [268, 272, 276].map(float)};
    }
    return {columns: [0, 1, 2].map(a => [0, 1, 2].map(i => i === a ? checkedSpacing(Math.abs(pixdim[a + 1])) : 0)), center: null};
};

// Reads one of the file's time steps.
const parseNifti = (bytes, step) => {
    const view = new DataView(bytes.buffer, bytes.byteOffset);
    const headerBytes = little => bytes.length >= 4 ? view.getInt32(0, little) : 0;
    if (headerBytes(true) === 540 || headerBytes(false) === 540) throw new Error('a NIfTI-2 file; the page reads NIfTI-1, isoshade view both');
    const little = headerBytes(true) === niftiHeaderBytes, short = o => view.getInt16(o, little), float = o => view.getFloat32(o, little);
    if (!little && headerBytes(false) !== niftiHeaderBytes) throw new Error('neither NRRD nor NIfTI; isoshade view reads other formats');
    if (bytes.length < niftiHeaderBytes + 4) throw new Error(`the file ends after ${bytes.length} bytes, within its header`);
    if (bytes[344] !== 110 || bytes[345] !== 43) throw new Error('a NIfTI header whose samples are in another file; isoshade view reads it');
    const type = niftiTypes[short(70)], unit = view.getUint8(123) & 7, mm = [1, 1e3, 1, 1e-3][unit];
    if (!type) throw new Error(`a NIfTI file of data type ${short(70)}; the page reads integers, float and double`);
    if (!mm) throw new Error(`its unit of lengths has the code ${unit}, which NIfTI does not define`);
    const sizes = Array.from({length: clamp(short(40), 0, 7)}, (_, a) => short(42 + 2 * a)), steps = Math.max(1, sizes[3] ?? 1);
    const size = threeSizes(sizes.map((n, axis) => axis === 3 ? 1 : n), 'NIfTI');
    const stepBytes = size[0] * size[1] * size[2] * sampleArrays[type].BYTES_PER_ELEMENT, offset = Math.round(float(108)) + step * stepBytes;
    const {columns, center} = niftiAffine(float, short), slope = float(112), intercept = float(116), scaled = Number.isFinite(slope) && slope !== 0 && Number.isFinite(intercept);
    return {steps, geometry: geometryOf(size, columns.map(c => scale(c, mm)), center && scale(center, mm), Boolean(center)),
        ...decodeSamples(bytes, offset, size, type, little, ...(scaled ? [slope, intercept] : []))};
};
