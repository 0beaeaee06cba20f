// SPDX-License-Identifier: MIT
// frames.js - schedules pictures: few pixels while something moves, all of them in bands afterwards, so that the page
// responds even if a whole picture takes a second.
// Turns rows of RGBA bytes upside down.
const topFirst = (bytes, width, rows) => {
    const turned = new Uint8ClampedArray(bytes.length), row = 4 * width;
    for (let y = 0; y < rows; ++y) turned.set(bytes.subarray((rows - 1 - y) * row, (rows - y) * row), y * row);
    return turned;
};

const makeFrames = (context, caster, data, state, canvas, told) => {
    const {gl} = context, bandMs = 45, movingMs = 60;
    const targets = new Map();
    let asked = 0, moving = false, perPixel = 2e-3, running = false, shown = {}; // perPixel: milliseconds, of the last
                                                                                 // bands; initially for software GL

    const targetOf = (name, width, height) => {
        const old = targets.get(name);
        if (old && old.width === width && old.height === height) return old;
        if (old) old.free();
        const made = context.target(width, height);
        targets.set(name, made);
        return made;
    };
    const camera = aspect => widened(state.camera, state.sceneAspect, aspect);
    const size = () => {
        const dots = Math.min(window.devicePixelRatio || 1, 2), box = canvas.getBoundingClientRect();
        return [Math.max(1, Math.round(box.width * dots)), Math.max(1, Math.round(box.height * dots))];
    };
    // Converts one or two pictures to display colors.
    const present = (frame, a, b, width, height) => {
        const display = context.program(['display.glsl']);
        gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
        gl.viewport(0, 0, width, height);
        display.use();
        for (const [unit, texture] of [[9, a.texture], [10, (b || a).texture]]) { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(gl.TEXTURE_2D, texture); }
        display.int('picture', 9);
        display.int('other', 10);
        display.int('mode', b ? {split: 1, difference: 2}[state.compare] : 0);
        display.float('line', state.line);
        display.float('amplified', state.amplified);
        display.vec2('screen', [width, height]);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    };
    const show = (a, b) => {
        const [width, height] = size();
        if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
        present(null, a, b, width, height);
        shown = {a, b};
    };

    // Draws one side at a size; null if a newer picture was requested meanwhile.
    const drawSide = async (side, kind, width, height, version) => {
        const target = targetOf(`${kind} ${side}`, width, height), q = {...requestOf(data, state, side), camera: camera(width / height)};
        let spent = 0;
        await Promise.all([caster.compiled(q), context.compiled(['display.glsl'])]);
        if (version !== asked) return null;
        for (let from = 0; from < height;) {
            const rows = kind === 'quick' ? height : Math.max(8, Math.round(bandMs / Math.max(perPixel * width, 1e-9)));
            const to = Math.min(height, from + rows), start = performance.now();
            caster.draw(q, target, from, to);
            await context.finished();
            const ms = performance.now() - start;
            spent += ms;
            if (from === 0 || rows > 32) perPixel = 0.5 * perPixel + 0.5 * ms / ((to - from) * width);
            from = to;
            if (version !== asked) return null;
        }
        return {target, ms: spent, q};
    };
    const drawAll = async (kind, width, height, version) => {
        const a = await drawSide('a', kind, width, height, version);
        const b = a && state.compare !== 'none' ? await drawSide('b', kind, width, height, version) : null;
        if (!a || (state.compare !== 'none' && !b)) return false;
        show(a.target, b?.target);
        told({kind, width, height, ms: a.ms, level: a.q.level.level, b});
        return true;
    };
    const run = async () => {
        running = true;
        while (!gl.isContextLost()) {
            const version = asked, [width, height] = size(), part = clamp(Math.sqrt(movingMs / Math.max(perPixel * width * height, 1e-9)), 0.12, 1);
            const quick = moving || part > 0.99;
            if (quick ? await drawAll('quick', Math.max(1, Math.round(width * part)), Math.max(1, Math.round(height * part)), version)
                : await drawAll('full', width, height, version)) {
                if (version === asked && (!quick || part > 0.99)) break;
                if (version === asked) { await new Promise(done => setTimeout(done, 120)); if (version === asked) moving = false; }
            }
            await new Promise(requestAnimationFrame);
        }
        running = false;
    };
    const ask = (moves = false) => {
        ++asked;
        moving = moves;
        if (!running) run().catch(problem => { running = false; if (!gl.isContextLost()) told(problem); });
    };
    const reshow = () => { if (shown.a && (state.compare === 'none') === !shown.b) show(shown.a, shown.b); else ask(); };
    // Resolves when the picture is drawn; while the context is lost, that is after it was made again.
    const settled = async () => { while (running || gl.isContextLost()) await new Promise(done => setTimeout(done, 20)); };

    // A picture for tests and `validate --with webgl`: linear, in floats, row 0 at the top; and its time.
    const measure = (width, height, side = 'a', repeats = 1) => {
        const target = context.target(width, height), q = {...requestOf(data, state, side), camera: camera(width / height)};
        let ms = Infinity;
        for (let i = 0; i < repeats; ++i) {
            const start = performance.now();
            caster.draw(q, target);
            context.read(target, 0, 0, 1, 1);
            ms = Math.min(ms, performance.now() - start);
        }
        const rgba = context.read(target);
        target.free();
        return {rgba, ms};
    };
    // A picture of any size, with A and B as on the screen, in bands: take(bytes, first row, rows), bytes in RGBA, from
    // the top row.
    const bands = async (width, height, take) => {
        const sides = state.compare === 'none' ? ['a'] : ['a', 'b'], view = camera(width / height), before = asked;
        for (let from = 0; from < height;) {
            const rows = Math.min(height - from, clamp(Math.round(bandMs / Math.max(perPixel * width, 1e-9)), 8, 1024));
            const part = {camera: view, height, firstRow: from};
            const targets = sides.map(() => context.target(width, rows));
            const out = context.target(width, rows, {bytes: true});
            sides.forEach((side, i) => caster.draw({...requestOf(data, state, side), ...part}, targets[i]));
            present(out.frame, targets[0], targets[1], width, rows);
            await context.finished();
            take(topFirst(context.read(out), width, rows), from, rows);
            for (const target of [...targets, out]) target.free();
            from += rows;
            if (asked !== before || gl.isContextLost()) throw new Error('the picture changed while it was saved; save it again');
        }
    };
    // After the context was lost: its pictures are gone.
    const forget = () => {
        targets.clear();
        shown = {};
    };
    return {forget, ask, reshow, settled, measure, bands, size, camera};
};
