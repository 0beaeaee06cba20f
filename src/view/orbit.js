// SPDX-License-Identifier: MIT
// orbit.js - pointer input on the picture: one finger or the left button orbits, two fingers or the right button pan
// and zoom.
// clicked(place), on a click or Enter, takes a point of the picture, 0 to 1 to the right and downwards.
const makeOrbit = (canvas, state, frames, clicked) => {
    const pointers = new Map();
    const move = camera => { state.camera = camera; frames.ask(true); };
    const height = () => canvas.getBoundingClientRect().height;
    const middle = () => scale([...pointers.values()].reduce((s, p) => [s[0] + p.x, s[1] + p.y], [0, 0]), 1 / pointers.size);
    const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    const onLine = e => state.compare === 'split' && Math.abs(e.clientX - canvas.getBoundingClientRect().left - state.line * canvas.getBoundingClientRect().width) < 12;

    canvas.addEventListener('pointerdown', e => {
        canvas.setPointerCapture(e.pointerId);
        canvas.focus({preventScroll: true});
        const [x, y] = [e.clientX, e.clientY];
        pointers.set(e.pointerId, {x, y, from: [x, y], button: e.button, line: onLine(e)});
    });
    canvas.addEventListener('pointermove', e => {
        const p = pointers.get(e.pointerId);
        canvas.style.cursor = !p && onLine(e) ? 'ew-resize' : '';
        if (!p) return;
        const before = middle(), apart = pointers.size === 2 ? spread() : 0, [dx, dy] = [e.clientX - p.x, e.clientY - p.y];
        Object.assign(p, {x: e.clientX, y: e.clientY});
        if (p.line) {
            const box = canvas.getBoundingClientRect();
            state.line = clamp((e.clientX - box.left) / box.width, 0, 1);
            frames.reshow();
        } else if (pointers.size === 2) {
            const after = middle();
            const shifted = panned(state.camera, (after[0] - before[0]) / height(), (after[1] - before[1]) / height());
            move(apart > 0 ? zoomed(shifted, spread() / apart) : shifted);
        } else if (p.button === 2 || p.button === 1 || e.shiftKey) {
            move(panned(state.camera, dx / height(), dy / height()));
        } else if (pointers.size === 1) {
            move(orbited(state.camera, dx / height() * Math.PI, dy / height() * Math.PI));
        }
    });
    canvas.addEventListener('pointerup', e => {
        const p = pointers.get(e.pointerId), box = canvas.getBoundingClientRect();
        const isStill = p && Math.hypot(e.clientX - p.from[0], e.clientY - p.from[1]) < 4;
        if (isStill && pointers.size === 1 && p.button === 0 && !p.line)
            clicked([(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height]);
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, e => pointers.delete(e.pointerId));
    canvas.addEventListener('contextmenu', e => e.preventDefault());
    canvas.addEventListener('wheel', e => { e.preventDefault(); move(zoomed(state.camera, Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015)))); }, {passive: false});
    canvas.addEventListener('keydown', e => {
        if (e.key === 'Enter') clicked([0.5, 0.5]);
        const turn = Math.PI / 24, [dx, dy] = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[e.key] || [0, 0];
        const camera = dx || dy ? (e.shiftKey ? panned(state.camera, 0.05 * dx, 0.05 * dy) : orbited(state.camera, turn * dx, turn * dy))
            : e.key === '+' || e.key === '=' ? zoomed(state.camera, 1.1) : e.key === '-' ? zoomed(state.camera, 1 / 1.1)
            : e.key === '[' ? rolled(state.camera, turn) : e.key === ']' ? rolled(state.camera, -turn) : null;
        if (!camera || e.ctrlKey || e.metaKey || e.altKey) return;
        e.preventDefault();
        move(camera);
    });
};
