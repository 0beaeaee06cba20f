// SPDX-License-Identifier: MIT
// open_samples.js - shared parts of the NRRD and NIfTI readers: samples, units, and checks of volumes. Files that
// isoshade refuses are refused here too, with a message about the problem.
const gunzip = async bytes => {
    const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
    try {
        return new Uint8Array(await new Response(unpacked).arrayBuffer());
    } catch {
        throw new Error('its compressed bytes are damaged, or the file ends too early');
    }
};

const sampleArrays = {
    int8: Int8Array, uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array, int32: Int32Array, uint32: Uint32Array,
    int64: BigInt64Array, uint64: BigUint64Array, float: Float32Array, double: Float64Array,
};
const machineIsLittle = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

const swapBytes = (bytes, width) => {
    for (let i = 0; i < bytes.length; i += width) bytes.subarray(i, i + width).reverse();
};

// The samples of one volume, in the file's type, or as floats if a slope scales them.
const decodeSamples = (bytes, offset, size, type, little, slope = 1, intercept = 0) => {
    const array = sampleArrays[type], width = array.BYTES_PER_ELEMENT, end = offset + size[0] * size[1] * size[2] * width;
    if (bytes.length < end) throw new Error(`the file ends after ${bytes.length} bytes, ${end} are needed`);
    const own = bytes.slice(offset, end); // aligned for its type
    if (width > 1 && little !== machineIsLittle) swapBytes(own, width);
    const stored = type.endsWith('64') ? Float64Array.from(new array(own.buffer), Number) : new array(own.buffer);
    if (slope === 1 && intercept === 0) return {type: type.endsWith('64') ? 'double' : type, values: stored};
    return {type: 'float', values: Float32Array.from(stored, v => slope * v + intercept)};
};

// Drops trailing axes with one sample.
const threeSizes = (sizes, format) => {
    const size = [...sizes];
    while (size.length > 3 && size[size.length - 1] === 1) size.pop();
    if (size.length !== 3) throw new Error(`a ${format} file of ${size.length} axes; the page reads scalars of three, isoshade view chooses a time step or a channel`);
    if (!size.every(n => Number.isInteger(n) && n > 0)) throw new Error(`its sizes are ${size.join(' x ')}, each must be at least 1`);
    return size;
};

// Millimeters per unit, with the names of volume/unit.c.
const unitWords = [
    [1, /^(mm|millimet(er|re)s?)?$/i], [1e3, /^(m|met(er|re)s?)$/i], [10, /^(cm|centimet(er|re)s?)$/i], [1e-3, /^([uµμ]m|micromet(er|re)s?|microns?)$/i],
    [1e-6, /^(nm|nanomet(er|re)s?)$/i], [1e-9, /^(pm|picomet(er|re)s?)$/i], [1e-7, /^(angstroms?|a|å|Å)$/i], [0.529177210903e-7, /^(bohrs?|a\.u\.)$/i],
    [25.4, /^(inch|in|inches)$/i],
];
const millimeters = word => {
    const found = unitWords.find(([, words]) => words.test(word));
    if (!found) throw new Error(`unknown unit "${word}"; use isoshade view --unit`);
    return found[0];
};

// The user must enter a missing spacing: there is no usual one.
const checkedSpacing = mm => {
    if (!(mm > 0 && Number.isFinite(mm))) throw new Error('does not state the spacing of its voxels; use isoshade view --spacing SXxSYxSZ, in mm');
    return mm;
};

// From voxel centers to outer corners: voxel i has its center at i + 1/2. center: of the first voxel; without it the
// volume is centered at the origin. isPatient: the world's axes are right, anterior, superior.
const geometryOf = (size, columns, center, isPatient) => {
    const first = center ?? columns.reduce((m, c, a) => madd(m, c, -(size[a] - 1) / 2), [0, 0, 0]);
    const spans = Math.abs(dot(columns[0], cross(columns[1], columns[2]))), lengths = columns.map(length);
    if (!(spans > 1e-9 * lengths[0] * lengths[1] * lengths[2]) || !Number.isFinite(spans))
        throw new Error(`its axes (spacings ${lengths.map(l => Number(l.toPrecision(3))).join(', ')} mm) span no volume`);
    if (!first.every(Number.isFinite)) throw new Error('its origin is not finite');
    const origin_mm = columns.reduce((o, c) => madd(o, c, -0.5), first);
    return {size, is_patient: isPatient, box_index: size, index_to_world: transpose(columns), origin_mm};
};
