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

// Numbers of an array's text; of a level's scalars, with the ranges of its bricks.
const decodeArray = async (text, d) => {
    const packed = await inflate(fromBase64(await text.text())), {count, components, bytes} = d;
    if (packed.length !== count * components * bytes)
        throw new Error(`${d.array}: ${packed.length} bytes, expected ${count * components * bytes}`);
    const whole = numbersOf(packed, d), numbers = d.kind === 'float' ? new Float32Array(whole.buffer) : whole;
    return {numbers, ranges: d.size && brickRanges(numbers, d.size)};
};
// Tasks for a worker, which runs the page's own script, so that the page goes on.
const tasks = {decode: (text, d) => decodeArray(text, d), open: (file, step, most) => readVolume(file, step, most)};
const serve = () => {
    onmessage = ({data: {n, name, words}}) => tasks[name](...words).then(
        done => postMessage({n, done}, [done.numbers.buffer]), problem => postMessage({n, problem: problem.message}));
};
// run(name, ...words) does a task in the worker, or here if the browser forbids workers.
const makeWorker = script => {
    const waiting = new Map(), made = {count: 0, here: 0};
    let worker = null;
    const here = (name, words) => {
        ++made.here;
        return tasks[name](...words);
    };
    const end = () => {
        for (const {take, name, words} of waiting.values()) take(here(name, words));
        waiting.clear();
        worker = null;
    };
    try {
        worker = new Worker(URL.createObjectURL(new Blob([script])));
        worker.onerror = end;
        worker.onmessage = ({data: {n, done, problem}}) => {
            const {take, fail} = waiting.get(n);
            waiting.delete(n);
            if (done) take(done);
            else fail(new Error(problem));
        };
    } catch { /* forbidden */ }
    made.run = (name, ...words) => !worker ? here(name, words) : new Promise((take, fail) => {
        waiting.set(++made.count, {take, fail, name, words});
        worker.postMessage({n: made.count, name, words});
    });
    return made;
};

// Drops an element and returns its text, taken in parts so that the page goes on. It would otherwise stay in memory; the
// browser may keep the blob on disk until the page is saved.
const takeText = async element => {
    const parts = [], most = 2 ** 20;
    for (const node of element.childNodes)
        for (let at = 0; at < node.length; at += most) {
            parts.push(new Blob([node.substringData(at, most)]));
            if (node.length > most) await pause();
        }
    element.remove();
    return new Blob(parts);
};
const readArray = async (worker, d, size) => {
    d.text = await takeText(document.getElementById(d.array));
    return worker.run('decode', d.text, {...d, text: undefined, size});
};
const megabytes = bytes => bytes >= 995e4 ? `${Math.round(bytes / 1e6)} MB` : bytes >= 995e2 ? `${(bytes / 1e6).toFixed(1)} MB` : `${Math.max(1, Math.round(bytes / 1e3))} kB`;
