// SPDX-License-Identifier: MIT
// The two formats of the contract: NRRD in, OpenEXR out.
import {openSync, readSync, closeSync, writeFileSync} from 'node:fs';

const types = {float: 'float32', uint8: 'uint8', uchar: 'uint8', 'unsigned char': 'uint8', uint16: 'uint16', ushort: 'uint16',
    'unsigned short': 'uint16', int16: 'int16', short: 'int16'};

// Where the samples of an attached raw NRRD begin, and what they are.
export const readNrrdHeader = path => {
    const file = openSync(path, 'r'), head = Buffer.alloc(65536);
    const got = readSync(file, head, 0, head.length, 0);
    closeSync(file);
    const end = head.subarray(0, got).indexOf('\n\n');
    if (!head.subarray(0, 4).equals(Buffer.from('NRRD')) || end < 0)
        throw new Error(`${path} is no NRRD file with its samples in it`);
    const fields = new Map(head.subarray(0, end).toString('latin1').split('\n').map(line => line.split(/:=?\s*/, 2)));
    const type = types[fields.get('type')];
    if (!type || fields.get('encoding') !== 'raw' || (fields.get('endian') ?? 'little') !== 'little')
        throw new Error(`${path}: ${fields.get('type')}, ${fields.get('encoding')}, ${fields.get('endian')} is not read here`);
    return {type, offset: end + 2, sizes: fields.get('sizes').trim().split(/\s+/).map(Number)};
};

// Float32 RGBA of rows from top to bottom, as scan lines without compression.
export const writeExr = (path, rgba, width, height) => {
    const text = s => Buffer.from(`${s}\0`, 'latin1');
    const i32 = (...values) => { const b = Buffer.alloc(4 * values.length); values.forEach((v, i) => b.writeInt32LE(v, 4 * i)); return b; };
    const f32 = (...values) => { const b = Buffer.alloc(4 * values.length); values.forEach((v, i) => b.writeFloatLE(v, 4 * i)); return b; };
    const attribute = (name, type, value) => Buffer.concat([text(name), text(type), i32(value.length), value]);
    const box = i32(0, 0, width - 1, height - 1), names = ['A', 'B', 'G', 'R']; // in the order of their names
    const channels = Buffer.concat([...names.map(c => Buffer.concat([text(c), i32(2, 0, 1, 1)])), Buffer.alloc(1)]);
    const head = Buffer.concat([
        i32(20000630, 2), attribute('channels', 'chlist', channels), attribute('compression', 'compression', Buffer.alloc(1)),
        attribute('dataWindow', 'box2i', box), attribute('displayWindow', 'box2i', box),
        attribute('lineOrder', 'lineOrder', Buffer.alloc(1)), attribute('pixelAspectRatio', 'float', f32(1)),
        attribute('screenWindowCenter', 'v2f', f32(0, 0)), attribute('screenWindowWidth', 'float', f32(1)), Buffer.alloc(1)]);
    const line = 8 + 16 * width, offsets = Buffer.alloc(8 * height), lines = Buffer.alloc(line * height);
    for (let y = 0; y < height; ++y) {
        offsets.writeBigUInt64LE(BigInt(head.length + 8 * height + line * y), 8 * y);
        lines.writeInt32LE(y, line * y);
        lines.writeInt32LE(16 * width, line * y + 4);
        names.forEach((name, c) => {
            for (let x = 0; x < width; ++x)
                lines.writeFloatLE(rgba[4 * (y * width + x) + 'RGBA'.indexOf(name)], line * y + 8 + 4 * (c * width + x));
        });
    }
    writeFileSync(path, Buffer.concat([head, offsets, lines]));
};
