// SPDX-License-Identifier: MIT
// controls.js - the panel: every control has a label, and changes one part of the state.
const element = (name, properties = {}, ...children) => {
    const e = Object.assign(document.createElement(name), properties);
    e.append(...children);
    return e;
};
const labeled = (text, control, after = '') => element('label', {}, element('span', {textContent: text}), control, after);
const choice = (options, value, chosen) => {
    const e = element('select', {}, ...options.map(([v, text]) => element('option', {value: v, textContent: text, selected: String(v) === String(value)})));
    e.addEventListener('change', () => chosen(e.value));
    return e;
};
// A slider with an editable number.
const slider = (text, {min, max, step, value}, changed) => {
    const range = element('input', {type: 'range', min, max, step, value}), typed = element('input', {type: 'number', min, max, step, value});
    const take = (from, to, moving) => {
        if (from.value === '') from.value = to.value; // invalid numbers change nothing
        const taken = clamp(Number(from.value), min, max);
        if (taken !== Number(from.value)) from.value = taken;
        to.value = from.value;
        changed(taken, moving);
    };
    range.addEventListener('input', () => take(range, typed, true));
    range.addEventListener('change', () => take(range, typed, false));
    typed.addEventListener('change', () => take(typed, range, false));
    range.setAttribute('aria-label', text);
    typed.setAttribute('aria-label', `${text}, number`);
    return element('div', {className: 'slider'}, element('span', {textContent: text}), range, typed);
};

const inUnit = data => data.value_unit ? `, ${data.value_unit}` : '';

// Makes controls again if their number changes. Keeps the keyboard focus on the control of the same name, or else on
// its neighbor.
const refill = (parent, ...children) => {
    const controls = () => [...parent.querySelectorAll('button, select, input')], before = controls(), at = before.indexOf(document.activeElement);
    const nameOf = e => e.getAttribute('aria-label') ?? e.closest('label')?.firstElementChild.textContent ?? e.textContent;
    const name = at < 0 ? '' : nameOf(before[at]), nth = before.slice(0, Math.max(at, 0)).filter(e => nameOf(e) === name).length;
    parent.replaceChildren(...children);
    if (at < 0) return;
    const after = controls().filter(e => !e.disabled), same = after.filter(e => nameOf(e) === name);
    (same[Math.min(nth, same.length - 1)] ?? after[Math.min(at, after.length - 1)])?.focus();
};

const makeControls = (data, state, frames, editor, page) => {
    const $ = id => document.getElementById(id), changed = moving => frames.ask(Boolean(moving));
    const levels = data.levels.map(l => l.level).sort((a, b) => a - b), sizeOf = n => data.levels.find(l => l.level === n).size.join(' × ');
    const whole = data.levels.filter(l => !l.isPlan).map(l => l.level).sort((a, b) => a - b), nameOf = n => n === planLevel ? `0 in planned bricks: ${sizeOf(n)}` : `${n}: ${sizeOf(n)}`;
    const codes = [...data.codes.map(c => [c, c]), ['', 'differences of the scalar']];

    // Level and shading, for A and for B.
    const what = (side, of) => {
        const adapt = element('input', {type: 'checkbox', checked: of.adapted});
        const row = labeled(`adapted transfer function${side}`, adapt);
        row.className = 'check';
        const cost = element('p', {className: 'hint'}), directions = choice(codes, of.code ?? '', v => { of.code = v || null; changed(); });
        const able = () => {
            const plan = data.levels.find(l => l.isPlan && l.level === of.level);
            const seen = (data.levels.find(l => l.level === of.level) || {}).seen, digits = x => Number(x.toPrecision(2));
            cost.textContent = seen ? `With the scene's transfer function, pictures of this level differ from level 0 by RMSE ${digits(seen.rmse)}, 1 - SSIM ${digits(seen.ssim_dissimilarity)}; adapted by ${digits(seen.rmse_adapted)} and ${digits(seen.ssim_dissimilarity_adapted)}: ${seen.adapting_helps ? 'adapting helps' : '--adapt keeps the original'}.` : '';
            if (plan) cost.textContent = planCost(plan);
            directions.disabled = Boolean(plan); // bricks have their own
            cost.hidden = !seen && !plan;
            adapt.disabled = !(data.levels.find(l => l.level === of.level) || {}).joint; row.classList.toggle('off', adapt.disabled);
        };
        adapt.addEventListener('change', () => { of.adapted = adapt.checked; changed(); });
        able();
        return [
            labeled(`level${side}`, choice(levels.map(n => [n, nameOf(n)]), of.level, v => { of.level = Number(v); able(); changed(); })),
            labeled(`directions${side}`, directions), row, cost,
        ];
    };
    const [{steps, shownStep, firstStep = 0}] = data.levels;
    const times = {min: firstStep, max: firstStep + steps - 1, step: 1, value: shownStep ?? firstStep};
    const time = () => slider('time step', times, v => data.toStep(v));
    const drawWhat = () => refill($('what'), ...(steps > 1 ? [time()] : []), ...what('', state));

    const presets = [['scene', 'of the scene'], ...data.presets.map(p => [p.name, p.name]), ['edited', 'edited']];
    const preset = choice(presets, 'scene', name => {
        const found = name === 'scene' ? data.scene.tf : name === 'edited' ? state.edited : data.presets.find(p => p.name === name).tf;
        editor.take(found, name);
    });
    $('preset').replaceChildren(labeled('preset', preset));
    const showPreset = () => {
        preset.lastElementChild.disabled = !state.edited; // the edited one is kept while others are tried
        preset.value = state.tfName;
    };

    // Views, and the projection.
    $('views').replaceChildren();
    for (const [name, direction, up] of viewpoints) {
        const b = element('button', {type: 'button', textContent: name});
        // Frames the box by the shorter side, since the sides of a wide scene need not be in the window.
        b.addEventListener('click', () => {
            state.sceneAspect = Math.min(1, state.sceneAspect);
            state.camera = lookingFrom(state.camera, data.geometry0, direction, up, state.sceneAspect);
            changed();
        });
        $('views').append(b);
    }
    const back = element('button', {type: 'button', textContent: 'scene'});
    back.addEventListener('click', () => {
        Object.assign(state, {camera: cameraOf(data.scene, data.geometry0), sceneAspect: aspectOf(data.scene)});
        drawProjection();
        changed();
    });
    $('views').append(back);
    const drawProjection = () => refill($('projection'), labeled('projection', choice([['perspective', 'perspective'], ['orthographic', 'orthographic']], state.camera.orthographic ? 'orthographic' : 'perspective', v => {
        const c = state.camera, depth = dot(subtract(c.lookAt, c.position), axesOf(c).forward);
        if ((v === 'orthographic') === c.orthographic) return;
        // Keeps the apparent size of the volume's middle.
        state.camera = c.orthographic ? {...c, orthographic: false, half: c.half / depth} : {...c, orthographic: true, half: c.half * depth};
        changed();
    })));

    const drawLights = () => {
        const list = state.lights.map((light, i) => {
            const d = normalize(light.direction), elevation = Math.asin(clamp(d[2], -1, 1)) * 180 / Math.PI, azimuth = Math.atan2(d[1], d[0]) * 180 / Math.PI;
            let angles = light.space === 'camera' ? [Math.atan2(d[0], d[2]) * 180 / Math.PI, Math.asin(clamp(d[1], -1, 1)) * 180 / Math.PI] : [azimuth, elevation];
            const turn = () => {
                const [a, e] = angles.map(x => x * Math.PI / 180);
                light.direction = light.space === 'camera' ? [Math.cos(e) * Math.sin(a), Math.sin(e), Math.cos(e) * Math.cos(a)] : [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
            };
            const remove = element('button', {type: 'button', textContent: 'remove', disabled: state.lights.length < 2});
            remove.setAttribute('aria-label', `remove light ${i + 1}`);
            remove.addEventListener('click', () => { state.lights.splice(i, 1); drawLights(); changed(); });
            return element('fieldset', {}, element('legend', {textContent: `light ${i + 1}`}),
                labeled('fixed to', choice([['camera', 'the camera'], ['world', 'the volume']], light.space, v => { light.space = v; angles = v === 'camera' ? [20, 30] : [45, 45]; turn(); drawLights(); changed(); })),
                slider('around', {min: -180, max: 180, step: 1, value: Math.round(angles[0])}, (v, m) => { angles[0] = v; turn(); changed(m); }),
                slider('above', {min: -90, max: 90, step: 1, value: Math.round(angles[1])}, (v, m) => { angles[1] = v; turn(); changed(m); }),
                slider('intensity', {min: 0, max: 1, step: 0.01, value: light.intensity}, (v, m) => { light.intensity = v; limit(); changed(m); }), remove);
        });
        const more = element('button', {type: 'button', textContent: 'add a light', disabled: state.lights.length >= 8});
        more.addEventListener('click', () => { state.lights.push({direction: [0.5, 0.5, 0.7], space: 'camera', intensity: 0.3}); limit(); drawLights(); changed(); });
        refill($('lights'), ...list, more);
    };
    // A scene needs ambient + diffuse * (sum of intensities) of at most 1: reduces the diffuse part.
    const limit = () => {
        const sum = state.lights.reduce((s, l) => s + l.intensity, 0), most = sum > 0 ? (1 - state.shading.ambient) / sum : 1;
        if (state.shading.diffuse > most) { state.shading = {...state.shading, diffuse: Math.floor(most * 1000) / 1000}; drawShading(); }
    };
    const drawShading = () => refill($('shading'), ...[['ambient', 0, 1, 0.01], ['diffuse', 0, 1, 0.001], ['specular', 0, 1, 0.01], ['power', 1, 200, 1]].map(([name, min, max, step]) =>
        slider(name, {min, max, step, value: state.shading[name]}, (v, m) => { state.shading = {...state.shading, [name]: v}; if (!m) limit(); changed(m); })),
    labeled('background', (() => {
        const e = element('input', {type: 'color', value: hexOf({r: state.background[0], g: state.background[1], b: state.background[2]})});
        e.addEventListener('input', () => { const {r, g, b} = linearOfHex(e.value); state.background = [r, g, b]; changed(true); });
        return e;
    })()));

    const drawClips = () => {
        const axes = [['x', [1, 0, 0]], ['-x', [-1, 0, 0]], ['y', [0, 1, 0]], ['-y', [0, -1, 0]], ['z', [0, 0, 1]], ['-z', [0, 0, -1]]];
        const list = state.clips.map((clip, i) => {
            const same = axes.find(([, n]) => dot(n, normalize(clip.normal)) > 0.9999), remove = element('button', {type: 'button', textContent: 'remove'});
            remove.setAttribute('aria-label', `remove clip plane ${i + 1}`);
            remove.addEventListener('click', () => { state.clips = state.clips.filter((c, j) => j !== i); drawClips(); changed(); });
            const set = (change, moving) => { state.clips = state.clips.map((c, j) => j === i ? {...c, ...change} : c); changed(moving); };
            return element('fieldset', {}, element('legend', {textContent: `plane ${i + 1}`}),
                labeled('stays', choice([...axes.map(([name]) => [name, `towards ${name}`]), ...(same ? [] : [['other', 'as in the scene']])], same ? same[0] : 'other', v => { const found = axes.find(([n]) => n === v); if (found) set({normal: found[1]}); })),
                ...(clip.point_mm ? [] : [slider('from', {min: 0, max: 1, step: 0.005, value: clip.at}, (v, m) => set({at: v}, m))]), remove);
        });
        const more = element('button', {type: 'button', textContent: 'add a plane', disabled: state.clips.length >= 6});
        more.addEventListener('click', () => { state.clips = [...state.clips, {normal: [1, 0, 0], at: 0.5}]; drawClips(); changed(); });
        refill($('clips'), ...list, more);
    };

    // Draws a finer level inside the box than around it. A level inside whose voxels have data in part is not drawn.
    const inner = whole.slice(0, -1).filter(n => !data.levels.find(l => l.level === n).share);
    const drawRoi = () => {
        const on = element('input', {type: 'checkbox', checked: Boolean(state.roi)}), row = labeled('finer level inside a box', on), parts = [row];
        row.className = 'check';
        on.addEventListener('change', () => {
            const outside = state.roi?.outside; // restores the outer level that was replaced by a coarser one
            state.roi = on.checked ? {level: inner[0], box: [[0.3, 0.3, 0.3], [0.7, 0.7, 0.7]], band: 2} : null;
            if (state.roi && state.level <= whole[0]) Object.assign(state, {level: whole[1], roi: {...state.roi, outside: state.level}});
            else if (outside !== undefined && state.level === whole[1]) state.level = outside;
            drawWhat();
            drawRoi();
            changed();
        });
        const set = (change, moving) => { state.roi = {...state.roi, ...change}; changed(moving); };
        if (state.roi) {
            parts.push(labeled('level inside', choice(inner.map(n => [n, `${n}: ${sizeOf(n)}`]), state.roi.level, v => set({level: Number(v)}))));
            for (const a of [0, 1, 2]) for (const side of [0, 1])
                parts.push(slider(`${'xyz'[a]} ${side ? 'to' : 'from'}`, {min: 0, max: 1, step: 0.01, value: state.roi.box[side][a]}, (v, m) => {
                    const box = state.roi.box.map(corner => [...corner]);
                    box[side][a] = side ? Math.max(v, box[0][a] + 0.01) : Math.min(v, box[1][a] - 0.01);
                    set({box}, m);
                }));
            parts.push(slider('band, voxels', {min: 0, max: 16, step: 0.5, value: state.roi.band}, (v, m) => set({band: v}, m)),
                element('p', {className: 'hint', textContent: 'Needs a coarser level outside, and coded directions. The scene file does not include the box; the command below does.'}));
        }
        if (!inner.length) on.disabled = true;
        refill($('roi'), ...parts);
    };
    const drawCompare = () => {
        const parts = [labeled('show', choice([['none', 'A alone'], ['split', 'A and B, side by side'], ['difference', 'their difference']], state.compare, v => { state.compare = v; drawCompare(); changed(); }))];
        if (state.compare !== 'none') parts.push(...what(' B', state.b));
        if (state.compare === 'split') parts.push(slider('line', {min: 0, max: 1, step: 0.01, value: state.line}, v => { state.line = v; frames.reshow(); }));
        const scale = element('p', {className: 'hint'}), tell = () => { scale.textContent = `Black: equal; brightest: a difference of ${Number((1 / state.amplified).toPrecision(2))} or more (1: white against black).`; };
        tell();
        if (state.compare === 'difference') parts.push(slider('times', {min: 1, max: 100, step: 1, value: state.amplified}, v => { state.amplified = v; tell(); frames.reshow(); }), scale);
        refill($('compare'), ...parts);
        $('picture').parentElement.dataset.compare = state.compare;
    };
    const drawStep = () => refill($('step'), slider('step, voxels', {min: 0.1, max: 4, step: 0.05, value: state.step}, (v, m) => { state.step = v; changed(m); }));
    drawStep();

    const pictureSize = () => { const box = document.getElementById('picture').getBoundingClientRect(); return [Math.round(box.width), Math.round(box.height)]; };
    const sceneNow = () => { const [w, h] = pictureSize(); return sceneJson(data, state, frames.camera(w / h), w, h); };
    $('save-scene').onclick = () => saveJson('scene.json', sceneNow());
    $('save-tf').onclick = () => saveJson('tf.json', tfJson(data, state));
    $('save-page').disabled = data.levels.some(l => !l.numbers);
    $('save-page').onclick = async () => {
        try {
            saveBlob(`${baseName(data)}.html`, await page(data, state));
        } catch (problem) { say(problem.message); }
    };
    if (!$('save-width').value) $('save-width').value = frames.size()[0];
    $('save-picture').onclick = async () => {
        const width = clamp(Math.round(Number($('save-width').value)) || frames.size()[0], 16, 16384);
        $('save-width').value = width;
        const told = part => { $('status').textContent = `saving the picture: ${Math.round(100 * part)} %`; };
        try {
            saveBlob(`${baseName(data)}.png`, await pictureBlob(frames, width, told));
        } catch (problem) { say(problem.message); }
        frames.ask();
    };
    const showCommand = () => { $('command').textContent = commandOf(data, state); };
    // If the browser forbids the clipboard, selects the text.
    const copying = (button, text, shown) => { button.onclick = async () => {
        const label = button.textContent;
        const copied = await navigator.clipboard?.writeText(text()).then(() => true, () => false);
        if (!copied && shown) getSelection().selectAllChildren(shown);
        button.textContent = copied ? 'copied' : shown ? 'selected' : 'copy the address instead';
        setTimeout(() => { button.textContent = label; }, 1500);
    }; };
    copying($('copy'), () => $('command').textContent, $('command'));
    copying($('copy-link'), () => location.href);

    for (const draw of [drawWhat, drawLights, drawShading, drawClips, drawRoi, drawCompare, drawProjection, showPreset, showCommand]) draw();
    return {sceneNow, tfNow: () => tfJson(data, state), showCommand, showPreset, drawWhat, drawStep};
};
