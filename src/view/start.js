// SPDX-License-Identifier: MIT
// start.js - reads the coarsest level, draws it, then reads finer ones as the browser loads them.
const say = (...parts) => {
    const message = document.getElementById('message');
    message.firstElementChild.replaceChildren(...parts);
    message.hidden = !message.firstElementChild.textContent;
};
const start = async () => {
    const worker = makeWorker(document.currentScript.textContent), page = keepPage();
    const $ = id => document.getElementById(id), data = JSON.parse($('data').textContent), canvas = $('picture');
    $('close-message').onclick = () => { say(''); canvas.focus(); };
    const inAddress = () => new URLSearchParams(location.hash.slice(1));
    const showCompact = () => document.body.classList.toggle('compact', data.compact || inAddress().has('compact'));
    showCompact();
    const togglePanel = () => $('settings').setAttribute('aria-expanded', document.body.classList.toggle('panel'));
    $('settings').onclick = togglePanel;
    // Levels come coarsest first; level 0's geometry is that of the volume even if its voxels are left out.
    data.geometry0 = data.geometry;
    const showTitle = () => {
        $('title').textContent = document.title = data.title;
        canvas.ariaLabel = canvas.ariaLabel.replace(/^.*?(?=, volume rendering)/, () => data.title);
    };
    if ($('title').textContent !== data.title) showTitle();
    if (data.plan) data.levels.push(levelOfPlan(data.plan, data.geometry0));
    const context = await makeContext(canvas);
    if (!context) { say('This browser has no WebGL2, or it is switched off: the volume cannot be drawn here.'); return; }
    const state = makeState(data), held = data.overlay, caster = makeCaster(context, data);
    const packed = () => data.levels.flatMap(l => [l.scalar, ...l.codes, l.share, l.joint, l.layout].filter(Boolean)).reduce((sum, d) => sum + d.packed, 0);
    const pageBytes = packed() * 4 / 3 + 16e4; // base64; the page itself
    let controls = null, outline = null, slices = null, edits = null, noted = 0;
    const noteSoon = () => {
        clearTimeout(noted);
        noted = setTimeout(() => edits?.note(), 300); // after a drag, not during it
    };
    const status = told => {
        if (told instanceof Error) { say(told.message); document.documentElement.dataset.failed = told.message; throw told; }
        const wait = data.levels.filter(l => !l.numbers).length;
        const quick = told.kind === 'quick' && (told.width !== canvas.width);
        const named = level => level === planLevel ? 'level 0 in planned bricks' : `level ${level}`;
        if (!quick) $('status').textContent = `${told.b ? `A: ${named(told.level)}, B: ${named(told.b.q.level.level)}` : named(told.level)} · ${told.width} × ${told.height} pixels in ${told.ms < 10 ? told.ms.toFixed(1) : Math.round(told.ms)} ms · page ${megabytes(pageBytes)}, textures ${megabytes(caster.bytes())}${wait ? ` · reading ${wait} finer level${wait > 1 ? 's' : ''}` : ''}`;
        document.documentElement.dataset.shown = told.kind;
        if (!document.documentElement.dataset.first) document.documentElement.dataset.first = Math.round(performance.now());
        outline?.();
        slices?.draw();
        controls?.showCommand();
        noteSoon();
    };
    const frames = makeFrames(context, caster, data, state, canvas, status);
    outline = makeOutline($('outline'), data, state, frames);
    const editor = makeEditor($('editor'), data, state, moving => { controls?.showPreset(); frames.ask(moving); });

    const read = (d, size) => readArray(worker, d, size);
    data.overlay = null; // until it is read
    const readOverlay = async () => {
        const {numbers, ranges} = await read(held.level.scalar, held.level.size);
        await caster.prepare(held.level, numbers, null);
        Object.assign(held.level, {numbers, ranges});
        data.overlay ??= held;
        slices.panel();
        frames.ask();
        await frames.settled();
    };
    const readStep = async (level, n) => {
        const {step, scalar, ...about} = level.held[n - level.firstStep];
        scalar.text ??= await takeText($(scalar.array));
        const array = {...scalar, text: undefined, size: level.size};
        return {...about, scalar, ...await worker.run('decode', scalar.text, array)};
    };
    const readLevel = async level => {
        if (level.isPlan) return readPlan(level, read);
        const {numbers, ranges} = await read(level.scalar, level.size);
        for (const code of level.codes) code.numbers = (await read(code)).numbers;
        if (level.share) level.share.numbers = (await read(level.share)).numbers;
        if (level.joint) level.adapter = makeAdapter((await read(level.joint)).numbers, level.joint);
        if (level.held) level.readStep = n => readStep(level, n);
        await caster.prepare(level, numbers, state.code);
        Object.assign(level, {numbers, ranges}); // shown from now on
    };
    // A context is lost if a picture takes too long or memory runs out; all of it is made again if the browser allows.
    canvas.addEventListener('webglcontextlost', e => {
        e.preventDefault();
        say('The graphics card stopped this page: a picture took too long, or memory ran out. If nothing follows, reload the page, and choose a coarser level or a larger step.');
    });
    canvas.addEventListener('webglcontextrestored', () => {
        context.begin();
        caster.forget([...data.levels, ...data.overlay ? [data.overlay.level] : []]);
        frames.forget();
        say('');
        frames.ask();
    });
    await readLevel(data.levels[0]);
    const moved = () => { outline(); slices.draw(); noteSoon(); };
    slices = makeSlices(canvas.closest('.frame'), data, state, {caster, frames, worker, most: context.most}, moved);
    // Escape leaves one thing after the other, the topmost first; the keyboard goes back to where that was opened.
    addEventListener('keydown', e => {
        if (e.key !== 'Escape' || e.defaultPrevented) return;
        if (!$('message').hidden) $('close-message').click();
        else if (document.body.classList.contains('compact') && document.body.classList.contains('panel')) {
            togglePanel();
            $('settings').focus();
        } else slices.leave();
    });
    // Selects the finest level; until it is read, the finest one so far is drawn.
    state.level = state.b.level = data.levels[data.levels.length - 1].level;
    if (data.levels.length > 1) state.b.level = data.levels[data.levels.length - 2].level;
    const showState = () => {
        if (!controls) return;
        window.isoshade.controls = controls = makeControls(data, state, frames, editor, page);
        editor.take(state.tf, state.tfName);
        slices.panel();
    };
    const take = kept => {
        try { restore(state, kept); } catch (problem) { say(problem.message); return; }
        showState();
    };
    if ($('state')) take(JSON.parse($('state').textContent));
    // "#level=1&adapted&code=none&step=0.5": options in links of reports and charts. "#state=...": the whole state.
    const follow = async () => {
        showCompact();
        const asked = inAddress(), level = Number(asked.get('level') ?? NaN);
        if ([...asked.keys()].every(key => key === 'compact')) return;
        if (asked.has('state')) {
            const kept = await textOfLink(asked.get('state')).then(JSON.parse).catch(() => null);
            if (JSON.stringify(kept) !== JSON.stringify(state)) take(kept);
            return;
        }
        if (data.levels.some(l => l.level === level)) state.level = level;
        else if (level === 0 && data.plan) state.level = planLevel;
        state.adapted = asked.has('adapted');
        if (Number(asked.get('step')) > 0) state.step = Math.min(Math.max(Number(asked.get('step')), 0.1), 4);
        state.code = asked.get('code') === 'none' ? null : data.codes.includes(asked.get('code')) ? asked.get('code') : state.code;
        controls?.drawWhat();
        controls?.drawStep();
        if (controls) frames.ask();
    };
    await follow();
    addEventListener('hashchange', follow);
    controls = makeControls(data, state, frames, editor, page);
    edits = makeHistory(data, state, showState);
    editor.count(data.levels[0]);
    slices.panel();
    makeOrbit(canvas, state, frames, place => {
        const [width, height] = frames.size();
        slices.clicked(frames.camera(width / height), width / height, place);
    });
    new ResizeObserver(() => frames.ask()).observe(canvas);
    // For tests and `validate`.
    window.isoshade = {data, state, frames, editor, controls, context, caster, edits, page, slices, worker};
    const followSteps = level => {
        data.toStep = async step => {
            await frames.settled();
            await changeStep(data, state, caster, step);
            editor.count(level);
            frames.ask();
        };
    };
    if (data.levels[0].held) followSteps(data.levels[0]);
    acceptFiles(canvas.closest('.frame'), $('open'), async file => {
        const level = await openFile(worker, file, context.most), old = data.levels;
        await caster.prepare(level, level.numbers, null);
        await frames.settled();
        caster.forget(old);
        followSteps(level);
        replaceVolume(data, state, level, file.name);
        showTitle();
        controls = makeControls(data, state, frames, editor, page);
        edits = makeHistory(data, state, showState);
        editor.count(level);
        slices.panel();
        Object.assign(window.isoshade, {controls, edits});
        frames.ask();
    });
    frames.ask(true); // few pixels first, for an immediate picture
    await frames.settled();
    if (document.readyState === 'loading') await new Promise(done => document.addEventListener('DOMContentLoaded', done, {once: true}));
    const all = data.levels;
    for (const level of all.slice(1)) {
        await readLevel(level);
        if (data.levels !== all) return; // another volume was opened meanwhile
        frames.ask();
        await frames.settled();
    }
    if (held) await readOverlay();
    editor.count(data.levels.findLast(l => !l.isPlan));
    $('save-page').disabled = false;
    document.documentElement.dataset.ready = 'yes';
};
if (typeof document === 'undefined') serve();
else start().catch(problem => {
    say(`This page could not be shown: ${problem.message}`);
    document.documentElement.dataset.failed = problem.message;
    throw problem;
});
