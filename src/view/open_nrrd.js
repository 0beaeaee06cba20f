// SPDX-License-Identifier: MIT
// open_nrrd.js - reads a NRRD file's bytes as a volume, like volume/nrrd_open.c: raw and gzip, three axes.
const nrrdTypes = {
    'signed char': 'int8', int8: 'int8', int8_t: 'int8', uchar: 'uint8', 'unsigned char': 'uint8', uint8: 'uint8', uint8_t: 'uint8',
    short: 'int16', 'short int': 'int16', 'signed short': 'int16', 'signed short int': 'int16', int16: 'int16', int16_t: 'int16',
    ushort: 'uint16', 'unsigned short': 'uint16', 'unsigned short int': 'uint16', uint16: 'uint16', uint16_t: 'uint16',
    int: 'int32', 'signed int': 'int32', int32: 'int32', int32_t: 'int32', uint: 'uint32', 'unsigned int': 'uint32', uint32: 'uint32', uint32_t: 'uint32',
    longlong: 'int64', 'long long': 'int64', 'long long int': 'int64', 'signed long long': 'int64', 'signed long long int': 'int64', int64: 'int64', int64_t: 'int64',
    ulonglong: 'uint64', 'unsigned long long': 'uint64', 'unsigned long long int': 'uint64', uint64: 'uint64', uint64_t: 'uint64',
    float: 'float', double: 'double',
};
// Fields ("byte skip: 4", with names without spaces), keys ("name:=value"), and the start of the samples.
const nrrdHeader = bytes => {
    const isLineEnd = i => bytes[i] === 10 && (bytes[i + 1] === 10 || (bytes[i + 1] === 13 && bytes[i + 2] === 10));
    let end = 0;
    while (end < bytes.length && !isLineEnd(end)) ++end;
    if (end === bytes.length) throw new Error('its NRRD header does not end: the file is cut');
    const field = {}, key = {};
    for (const line of new TextDecoder().decode(bytes.subarray(0, end)).split(/\r?\n/).slice(1)) {
        const found = /^([^#:][^:]*):(=?)(.*)$/.exec(line);
        if (!found) continue;
        if (found[2]) key[found[1]] = found[3];
        else field[found[1].replace(/\s/g, '').toLowerCase()] = found[3].trim();
    }
    return {field, key, start: end + (bytes[end + 1] === 13 ? 3 : 2)};
};
const wordsOf = text => (text ?? '').split(/[\s,]+/).filter(Boolean);
const unitsOf = text => [0, 1, 2].map(a => millimeters([...(text ?? '').matchAll(/"([^"]*)"/g)][a]?.[1] ?? ''));

// Directions in the space; in right, anterior, superior for a space of a body.
const orientedNrrd = (field, size) => {
    const isPatient = /^((left-posterior|(left|right)-anterior)-superior|lps|las|ras)$/i.test(field.space ?? '');
    const signs = /^(left-posterior-superior|lps)$/i.test(field.space ?? '') ? [-1, -1, 1] : /^(left-anterior-superior|las)$/i.test(field.space ?? '') ? [-1, 1, 1] : [1, 1, 1];
    const factors = unitsOf(field.spaceunits).map((mm, i) => mm * signs[i]), placed = text => wordsOf(text).map((x, i) => Number(x) * factors[i]);
    const columns = [...(field.spacedirections ?? '').matchAll(/\(([^)]*)\)/g)].map(m => placed(m[1])), origin = /\(([^)]*)\)/.exec(field.spaceorigin ?? '');
    if (columns.length !== 3 || columns.some(c => c.length !== 3)) throw new Error('its space directions are not three vectors of three numbers');
    return geometryOf(size, columns, origin && placed(origin[1]), isPatient);
};
const plainNrrd = (field, size) => {
    const mm = unitsOf(field.units), given = wordsOf(field.spacings).map(Number), mins = wordsOf(field.axismins).map(Number);
    const spacing = mm.map((factor, a) => checkedSpacing(given[a]) * factor), columns = [0, 1, 2].map(a => [0, 1, 2].map(i => i === a ? spacing[a] : 0));
    const isNode = wordsOf(field.centerings ?? field.centers).map(w => w === 'node');
    const placed = [0, 1, 2].every(a => Number.isFinite(mins[a]));
    const center = placed ? spacing.map((s, a) => mins[a] * mm[a] + (isNode[a] ? 0 : 0.5 * s)) : null;
    return geometryOf(size, columns, center, false);
};

const parseNrrd = async bytes => {
    const {field, key, start} = nrrdHeader(bytes), type = nrrdTypes[(field.type ?? '').toLowerCase()], encoding = (field.encoding ?? 'raw').toLowerCase();
    if (field.datafile) throw new Error('the NRRD header names another file for its samples; isoshade view reads it');
    if (!type) throw new Error(`a NRRD file of type "${field.type ?? ''}"; a volume has integers, float or double`);
    if (!['raw', 'gzip', 'gz'].includes(encoding)) throw new Error(`a NRRD file in ${encoding}; the page reads raw and gzip, isoshade view the others`);
    const size = threeSizes(wordsOf(field.sizes).map(Number), 'NRRD');
    const kinds = wordsOf(field.kinds).slice(0, 3).filter(kind => !/^(\?\?\?|none|domain|space)$/i.test(kind));
    if (kinds.length) throw new Error(`a NRRD file with an axis of kind ${kinds[0]}; the page reads scalars of three axes of space`);
    let samples = bytes.subarray(start);
    for (let lines = Number(field.lineskip ?? 0); lines > 0; --lines) samples = samples.subarray(samples.indexOf(10) + 1);
    if (encoding !== 'raw') samples = await gunzip(samples);
    const skip = Number(field.byteskip ?? 0), needed = size[0] * size[1] * size[2] * sampleArrays[type].BYTES_PER_ELEMENT;
    const offset = skip < 0 ? samples.length - needed + skip + 1 : skip; // -1: the samples are the end of the file
    if (offset < 0) throw new Error(`the file holds ${samples.length} bytes of samples, ${needed} are needed`);
    const scales = [['scale_slope', 'scale_intercept'], ['nifti_scl_slope', 'nifti_scl_inter']].map(names => names.map(n => Number(key[n] ?? 0)));
    const [slope, intercept] = scales.findLast(([s, i]) => s && Number.isFinite(s) && Number.isFinite(i)) ?? [1, 0];
    const inSpace = field.space !== undefined || field.spacedimension !== undefined;
    const value_unit = (field.sampleunits ?? '').replace(/^"([^"]*)"$/, '$1').slice(0, 15);
    const isLittle = (field.endian ?? 'little').toLowerCase() === 'little', geometry = (inSpace ? orientedNrrd : plainNrrd)(field, size);
    return {value_unit, geometry, ...decodeSamples(samples, offset, size, type, isLittle, slope, intercept)};
};
