// SPDX-License-Identifier: MIT
// save.js - what leaves the page: files, pictures of any size, the page with its edits, and links to its state.
const saveBlob = (name, blob) => {
    const link = element('a', {href: URL.createObjectURL(blob), download: name});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    if (self !== top) offerLink(name, blob);
};
// A page around this one may forbid to save, without a word; a person may still save the target of a link.
const offerLink = (name, blob) => {
    const reader = new FileReader(), link = element('a', {download: name, textContent: name});
    reader.onload = () => {
        link.href = reader.result;
        say('If nothing was saved, save the target of this link: ', link);
    };
    reader.readAsDataURL(blob);
};
const textOf = json => JSON.stringify(json, null, 2) + '\n';
const saveJson = (name, json) => saveBlob(name, new Blob([textOf(json)], {type: 'application/json'}));
const baseName = data => data.title.replace(/[^\w.-]+/g, '_').replace(/(\.nii|\.iso|\.nrrd)?(\.gz)?$/, '') || 'picture';

// Returns a PNG of the picture. Its pixels are square; the height follows from the shape of the picture on the screen.
const pictureBlob = async (frames, width, told) => {
    const [w, h] = frames.size(), height = Math.max(1, Math.round(width * h / w));
    const canvas = Object.assign(document.createElement('canvas'), {width, height}), paint = canvas.getContext('2d');
    if (!paint) throw new Error(`a picture of ${width} x ${height} pixels is too large for this browser`);
    await frames.bands(width, height, (bytes, from, rows) => {
        paint.putImageData(new ImageData(bytes, width, rows), 0, from);
        told((from + rows) / height);
    });
    const blob = await new Promise(done => canvas.toBlob(done, 'image/png'));
    if (!blob) throw new Error(`a picture of ${width} x ${height} pixels is too large for this browser`);
    return blob;
};

// ---- the page ----
// The page's parts as they were before the script changed them. A saved page holds them, the data, and the state.
const keepPage = () => {
    const partOf = selector => document.querySelector(selector).outerHTML;
    const script = document.currentScript.outerHTML, parts = ['noscript', '#shaders'].map(partOf).join('\n');
    const dataText = document.getElementById('data').textContent;
    const before = `\x3c!doctype html>\n\x3c!-- SPDX-License-Identifier: MIT -->\n\x3chtml lang="en">\n${partOf('head')}\n\x3cbody>\n`
        + `${partOf('main')}\n${parts}\n`;
    return async (data, state) => {
        const arrays = l => [l.scalar, ...l.codes, l.share, l.joint, l.layout].filter(Boolean);
        const isPacked = data.levels.every(l => l.scalar.text && !l.held);
        const json = isPacked ? JSON.parse(dataText) : {...data, geometry0: undefined, plan: undefined};
        const over = data.overlay;
        if (!isPacked) json.levels = [json.geometry = await packedLevel(data.levels[0], 'level-0-scalar')];
        json.overlay = over ? {name: over.name, level: await packedLevel(over.level, 'overlay-scalar')} : undefined;
        const [first, ...others] = (isPacked ? data.levels : json.levels).map(arrays);
        others.push(...json.levels[0].held?.map(arrays) ?? [], ...json.overlay ? [[json.overlay.level.scalar]] : []);
        // \x3c: the parser of HTML looks for elements in this script, too.
        const held = (attributes, text) => [`\x3cscript ${attributes}>`, text, '\x3c/script>\n'];
        const elements = list => list.flatMap(d => held(`type="text/plain" id="${d.array}"`, d.text));
        const without = (key, v) => key === 'text' ? undefined : v;
        const asText = value => JSON.stringify(value, without).replace(/</g, '\\u003c');
        return new Blob([before, ...held('type="application/json" id="data"', asText(json)),
            ...held('type="application/json" id="state"', asText(state)),
            ...elements(first), script, '\n', ...elements(others.flat()), '\x3c/body>\n\x3c/html>\n'], {type: 'text/html'});
    };
};
// Numbers as pack.h writes them: the bytes of each weight together, deflated, in base64. They have one component.
const packedArray = async (numbers, array) => {
    const count = numbers.length, bytes = numbers.BYTES_PER_ELEMENT, planes = new Uint8Array(count * bytes);
    const all = new Uint8Array(numbers.buffer, numbers.byteOffset, planes.length); // of a little-endian machine
    for (let w = 0, at = 0; w < bytes; ++w) for (let i = w; i < all.length; i += bytes) planes[at++] = all[i];
    const packed = await through(planes, new CompressionStream('deflate')), parts = [], most = 3 * 2 ** 13;
    for (let at = 0; at < packed.length; at += most)
        parts.push(btoa(String.fromCharCode(...packed.subarray(at, at + most))));
    return {array, count, components: 1, bytes, delta: false, packed: packed.length, text: new Blob(parts)};
};
const packedScalar = async ({scalar: {kind, zero, step, ...rest}, numbers}, name) =>
    ({kind, zero, step, ...rest.text ? {...rest, array: name} : await packedArray(numbers, name)});
// A level of one scalar for a saved page, with the time steps that fit: from the shown one on, then those before it.
const mostHeldBytes = 5e8;
const packedLevel = async (level, name) => {
    const {size, index_to_world, origin_mm, box_index, min, max, labels, has_no_data, value_unit} = level;
    const scalar = await packedScalar(level, name);
    const about = {size, index_to_world, origin_mm, box_index, level: 0, min, max, labels, has_no_data, value_unit};
    return {...about, codes: [], scalar, ...level.steps > 1 ? await packedSteps(level, scalar.packed) : {}};
};
const packedSteps = async (level, bytes) => {
    const {firstStep = 0, shownStep = firstStep, steps} = level, last = firstStep + steps - 1, held = [];
    const hold = async n => {
        const {min, max, window, has_no_data, ...made} = await level.readStep(n);
        const scalar = await packedScalar(made, `step-${n}`), fits = (bytes += scalar.packed) <= mostHeldBytes;
        if (fits) held.push({step: n, min, max, window, has_no_data, codes: [], scalar});
        return fits;
    };
    let fits = true;
    for (let n = shownStep; fits && n <= last; ++n) fits = await hold(n);
    for (let n = shownStep - 1; fits && n >= firstStep; --n) fits = await hold(n);
    held.sort((a, b) => a.step - b.step);
    if (!fits) say(`The saved page has ${held.length} time steps of ${steps}: those from ${held[0]?.step} on fit.`);
    return held.length ? {held, steps: held.length, firstStep: held[0].step, shownStep} : {};
};

// ---- the state ----
// True for values that JSON writes without loss: a link may hold anything.
const isPlain = v => v === null || ['boolean', 'string'].includes(typeof v) || Number.isFinite(v)
    || (typeof v === 'object' && Object.values(v).every(isPlain));
const sameKind = (a, b) => b !== null && Array.isArray(a) === Array.isArray(b) && typeof a === typeof b;
// Takes a kept state over. Throws if it is none of this page.
const restore = (state, kept) => {
    const may = {edited: true, roi: true, code: true, measure: true, window: true, overlay: true}; // null or a value
    const fits = key => key in kept && (may[key] || sameKind(state[key], kept[key]));
    const belongs = isPlain(kept) && kept && Object.keys(state).every(fits) && kept.tf.points?.length > 0;
    if (!belongs || kept.lights.length > 8 || kept.clips.length > 6 || !(kept.step >= 0.1))
        throw new Error('the state of the link does not belong to this page');
    for (const key of Object.keys(state)) state[key] = kept[key];
};
const through = async (bytes, stream) =>
    new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
const linkText = async text => {
    const bytes = await through(new TextEncoder().encode(text), new CompressionStream('deflate'));
    const text64 = btoa(bytes.reduce((s, b) => s + String.fromCharCode(b), ''));
    return text64.replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
};
const textOfLink = async link => {
    const bytes = fromBase64(link.replace(/-/g, '+').replace(/_/g, '/'));
    return new TextDecoder().decode(await through(bytes, new DecompressionStream('deflate')));
};

// Steps of editing. The address follows them, so that a reload or a copied link shows the same picture.
const makeHistory = (data, state, restored) => {
    const steps = [JSON.stringify(state)], $ = id => document.getElementById(id);
    let at = 0, changes = 0;
    const show = () => { $('undo').disabled = at === 0; $('redo').disabled = at === steps.length - 1; };
    const toAddress = async text => {
        const change = ++changes, link = await linkText(text);
        if (change !== changes) return;
        const kept = document.body.classList.contains('compact') && !data.compact ? 'compact&' : '';
        try { history.replaceState(null, '', `#${kept}state=${link}`); } catch { /* a page within a page has no address */ }
    };
    const go = by => {
        if (!(at + by in steps)) return;
        at += by;
        restore(state, JSON.parse(steps[at]));
        restored();
        show();
        toAddress(steps[at]);
    };
    show();
    $('undo').onclick = () => go(-1);
    $('redo').onclick = () => go(1);
    document.onkeydown = e => {
        const typing = e.target.matches?.('input[type="text"], input[type="number"]');
        if (!(e.ctrlKey || e.metaKey) || typing || !['z', 'y'].includes(e.key.toLowerCase())) return;
        e.preventDefault();
        go(e.key.toLowerCase() === 'y' || e.shiftKey ? 1 : -1);
    };
    return {
        // After a picture that shows the state as it is.
        note: () => {
            const text = JSON.stringify(state);
            if (text === steps[at]) return;
            steps.splice(at + 1, Infinity, text);
            if (steps.length > 200) steps.shift();
            at = steps.length - 1;
            show();
            toAddress(text);
        },
    };
};
