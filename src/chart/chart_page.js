// SPDX-License-Identifier: MIT
// The page of a chart: the plot, the selected setting, and the front as a table.
const cases = data.cases.map((c, at) => ({...c, ...data.figures[at], at})), series = [...new Set(cases.map(c => c.series))];
const several = data.scenes.length > 1, renderers = [...new Set(cases.map(c => c.renderer))];
const view = {scene: data.scenes[0].name, cost: 'milliseconds', own: false, chosen: null};
const titleOf = {milliseconds: `${data.options.time === 'processor' ? 'processor time' : 'time'} of a frame`, bytes: data.options.bytes === 'stored' ? 'bytes of the level in files' : 'bytes that the renderer holds'};
const time = c => view.cost === 'milliseconds', onFront = c => time() ? c.on_time_front : c.on_bytes_front, onOwn = c => time() ? c.on_renderer_time_front : c.on_renderer_bytes_front;
const wanted = data.want ? ['fastest', 'smallest'].map(k => data.want[k] && data.want[k].setting) : [];
const colorOf = renderer => data.colors[renderer] || palette[renderers.indexOf(renderer) % palette.length];
let plot = null;

// Link to the viewer's page, with options as close to the setting as it supports.
function viewerOf(c) {
    const page = data.scenes.find(s => s.name === c.scene).viewer;
    if (!page) return null;
    const words = [`level=${c.level}`, ...(c.tf === 'adapted' ? ['adapted'] : []), ...(c.shading_from === 'on-the-fly' ? ['code=none'] : []), `step=${c.step_voxels}`];
    return `${page}#${words.join('&')}`;
}

// ---- the setting ------------------------------------------------------------
function show(c) {
    const place = $('setting'), scene = data.scenes.findIndex(s => s.name === c.scene), picture = inlined.pictures[c.at], link = viewerOf(c);
    const row = (name, value) => el('tr', {}, cell(name), cell(value, true));
    place.replaceChildren(el('h3', {}, c.number ? `${c.number}  ${c.setting}` : c.setting),
        el('div', {class: 'pair'}, picture ? el('div', {}, el('img', {src: picture, alt: `picture of ${c.setting}`}), el('span', {}, 'this setting')) : el('p', {class: 'about'}, 'No picture in this page; the command renders it.'),
            el('div', {}, el('img', {src: inlined.references[scene], alt: 'the reference'}), el('span', {}, 'reference'))),
        el('table', {}, el('tbody', {}, row(data.metric_title, number(c.error)), row('a frame', `${number(c.milliseconds).textContent ?? number(c.milliseconds)} ms`),
            row('median', `${Number(c.milliseconds_median.toPrecision(3))} ms of ${c.frames}`), row('renderer holds', shown(c.device_bytes, 'B')), row('in files', shown(c.stored_bytes, 'B')), ...(c.build_seconds ? [row('level built in', `${number(c.build_seconds).textContent ?? number(c.build_seconds)} s`)] : []),
            ...(c.flip_mean === null || c.flip_mean === undefined ? [] : [row('mean FLIP', number(c.flip_mean)), row('1 − SSIM', number(1 - c.ssim))]))),
        command(c.command), ...(link ? [el('p', {}, el('a', {href: link}, 'open in the viewer'))] : []));
}
function point(p, keep) {
    plot.mark(p);
    if (!p) return;
    const c = cases[p.at];
    if (keep) view.chosen = c.at;
    show(c);
    for (const tr of document.querySelectorAll('tr[data-case]')) tr.classList.toggle('chosen', Number(tr.dataset.case) === c.at);
}
const pointOf = at => plot.points.find(p => p.at === at);
// The first setting to show: the wanted one, or the middle of the front.
const first = () => {
    const front = plot.points.filter(p => p.number || p.own).sort((a, b) => a.cost - b.cost);
    return plot.points.find(p => p.ring) || front[Math.floor(front.length / 2)] || plot.points[0];
};
const rest = () => point(pointOf(view.chosen) || first(), true);

// ---- pointer and keys -------------------------------------------------------
function listen(element) {
    const nearest = event => {
        const box = element.getBoundingClientRect(), scale = plot.wide / box.width, x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
        const far = p => (p.x - x) ** 2 + (p.y - y) ** 2, best = plot.points.reduce((a, b) => far(b) < far(a) ? b : a, plot.points[0]);
        return best && far(best) < 40 ** 2 ? best : null;
    };
    element.addEventListener('pointermove', event => { const p = nearest(event); if (p) point(p, false); });
    element.addEventListener('pointerdown', event => { const p = nearest(event); if (p) point(p, true); });
    element.addEventListener('pointerleave', rest);
    element.addEventListener('keydown', event => {
        const along = event.key === 'ArrowLeft' || event.key === 'ArrowRight', front = event.key === 'ArrowUp' || event.key === 'ArrowDown', ends = event.key === 'Home' || event.key === 'End';
        if (event.key === 'Enter') { const link = view.chosen !== null && viewerOf(cases[view.chosen]); if (link) location.href = link; return; }
        if (!along && !front && !ends) return;
        event.preventDefault();
        const list = plot.points.filter(p => along || ends || (view.own ? p.own : p.front)).sort((a, b) => a.cost - b.cost || b.error - a.error);
        const now = pointOf(view.chosen), i = list.indexOf(now), forward = event.key === 'ArrowRight' || event.key === 'ArrowDown';
        const next = ends ? (event.key === 'Home' ? 0 : list.length - 1) : i >= 0 ? i + (forward ? 1 : -1) : Math.max(list.findIndex(p => p.cost >= now.cost) - (forward ? 0 : 1), 0);
        point(list[Math.min(Math.max(next, 0), list.length - 1)], true);
    });
}

// ---- drawing ----------------------------------------------------------------
function draw() {
    const here = cases.filter(c => c.scene === view.scene), unit = time() ? 'ms' : 'B';
    plot = drawPlot({unit, wide: Math.round(Math.min(Math.max($('plot').clientWidth, 300), 860)), want: data.want ? data.wanted : 0, xTitle: titleOf[view.cost], yTitle: `${data.metric_title} to the reference of level 0`,
        byRenderer: view.own ? renderers.filter(r => here.some(c => c.renderer === r)).map(r => [r, colorOf(r)]) : null,
        points: here.map(c => ({at: c.at, cost: c[view.cost], error: c.error, renderer: c.renderer, number: onFront(c) && !view.own ? c.number : 0, front: !view.own && onFront(c), own: view.own && onOwn(c),
            ring: wanted[time() ? 0 : 1] === c.setting, size: 5.5 * 0.8 ** c.level, style: view.own ? {...styleOf(series.indexOf(c.series)), color: colorOf(c.renderer)} : styleOf(series.indexOf(c.series))}))});
    $('plot').replaceChildren(plot.element);
    listen(plot.element);
    const mark = style => svg('svg', {viewBox: '-8 -8 16 16', 'aria-hidden': 'true'}, svg('path', {fill: style.color, d: style.shape(5.5)}));
    $('legend').replaceChildren(...(view.own ? renderers.map(r => [r, {color: colorOf(r), shape: shapes[0]}]) : series.filter(s => here.some(c => c.series === s)).map(s => [s, styleOf(series.indexOf(s))]))
        .map(([name, style]) => el('li', {}, mark(style), name)), ...[...new Set(here.map(c => c.level))].sort().map(k => el('li', {}, svg('svg', {viewBox: '-8 -8 16 16', 'aria-hidden': 'true'}, svg('path', {fill: 'currentColor', d: shapes[0](5.5 * 0.8 ** k)})), `level ${k}`)));
    if (view.chosen !== null && cases[view.chosen].scene !== view.scene) {
        const same = here.find(c => c.setting === cases[view.chosen].setting);
        view.chosen = same ? same.at : null;
    }
    rest();
    table_();
    for (const b of document.querySelectorAll('[data-cost]')) b.setAttribute('aria-pressed', String(b.dataset.cost === view.cost));
    for (const b of document.querySelectorAll('[data-own]')) b.setAttribute('aria-pressed', String((b.dataset.own === 'yes') === view.own));
}
function table_() {
    const rows = cases.filter(c => c.scene === view.scene && (c.number || (view.own && onOwn(c)))).sort((a, b) => view.own ? renderers.indexOf(a.renderer) - renderers.indexOf(b.renderer) || b.error - a.error : a.number - b.number);
    for (const old of $('settings').querySelectorAll('.scroll')) old.remove();
    tables = 0;
    const tr = c => {
        const name = el('button', {type: 'button', class: 'open', onclick: () => { const p = pointOf(c.at); if (p) { point(p, true); plot.element.scrollIntoView({block: 'nearest'}); } }}, c.setting);
        return el('tr', {'data-case': c.at}, cell(c.number ? String(c.number) : '', true), cell(name), cell([c.on_time_front ? 'time' : '', c.on_bytes_front ? 'bytes' : ''].filter(s => s).join(', ') || 'its renderer'),
            cell(String(Number(c.milliseconds.toPrecision(3))), true), cell(shown(c.bytes, 'B'), true), cell(brief(c.error), true));
    };
    $('settings').append(table(view.own ? 'Each renderer’s own fronts.' : 'By falling error. Settings that lower it by less than 5 % have no number: timings are not that precise.',
        [['', 1], ['setting'], ['front of'], ['ms', 1], ['bytes', 1], [data.metric_title, 1]], rows.map(tr)));
    if (view.chosen !== null) for (const row of document.querySelectorAll('tr[data-case]')) row.classList.toggle('chosen', Number(row.dataset.case) === view.chosen);
}

// ---- the page ---------------------------------------------------------------
$('about').textContent = `${data.options.volume}; ${several ? 'scenes' : 'scene'} ${data.scenes.map(s => s.scene).join(', ')}; ${data.scenes.map(s => s.image.join(' × ')).filter((s, i, all) => all.indexOf(s) === i).join(', ')} pixels; ${cases.length} measured in ${Number(data.spent_seconds.toPrecision(3))} s${data.kept_count ? `, ${data.kept_count} of them in an earlier run` : ''}.`;
$('again').append(command(data.command));
const group = (name, buttons) => el('div', {class: 'group', role: 'group', 'aria-label': name}, buttons);
if (several) $('controls').append(el('label', {}, 'scene', el('select', {onchange: event => { view.scene = event.target.value; draw(); }}, data.scenes.map(s => el('option', {value: s.name}, s.name)))));
$('controls').append(group('cost', [['milliseconds', 'time'], ['bytes', 'bytes']].map(([key, name]) => el('button', {type: 'button', 'data-cost': key, onclick: () => { view.cost = key; draw(); }}, name))));
if (renderers.length > 1) $('controls').append(group('fronts', [['no', 'one front'], ['yes', 'a front per renderer']].map(([key, name]) => el('button', {type: 'button', 'data-own': key, onclick: () => { view.own = key === 'yes'; draw(); }}, name))));
$('figcaption').append(figcaption(`Each mark is a setting. On the line, the front, no other setting is better in both. Pale: not on the front. ${data.want ? `Dashed: the wanted ${data.metric_title} of ${plain(data.wanted)}; ringed: the fastest or the smallest setting within it. ` : ''}Point at a mark, or use the arrow keys, to see its picture, figures and command.`));
const left = Object.entries(data.left_out || {});
if (data.untried.length > 0 || data.skipped_count > 0 || left.length > 0) {
    $('missing').hidden = false;
    $('missing').append(el('p', {}, `${data.skipped_count} settings ${data.options.budget_seconds > 0 ? `did not fit into ${data.options.budget_seconds} s` : 'are of renderers that were left out'}.${data.untried.length ? ` None measured with: ${data.untried.join(', ')}.` : ''}`),
        ...left.map(([name, why]) => el('p', {}, `${name} was left out: ${why}`)));
    if (data.skipped_count > 0 && data.options.budget_seconds > 0) $('missing').append(el('p', {}, 'To continue, run the same command with --resume and a larger --budget.'));
}
$('colophon').append(el('table', {}, el('tbody', {}, [['isoshade', data.isoshade], ...Object.entries(data.versions), ['processor', `${data.machine.processor}, ${data.machine.cores} cores`]].map(([name, value]) => el('tr', {}, cell(name), cell(String(value)))))));
draw();
addEventListener('resize', () => { if (Math.abs(Math.min($('plot').clientWidth, 860) - plot.wide) > 20) draw(); });
document.documentElement.dataset.ready = 'yes';
