// SPDX-License-Identifier: MIT
'use strict';
(() => {
const data = JSON.parse(document.getElementById('data').textContent);
const inlined = JSON.parse(document.getElementById('inlined').textContent);
const $ = id => document.getElementById(id);

// ---- small builders ---------------------------------------------------------
function el(tag, attributes, ...children) {
    const e = document.createElement(tag);
    for (const [key, value] of Object.entries(attributes || {})) {
        if (key.startsWith('on')) e.addEventListener(key.slice(2), value);
        else if (value !== null && value !== undefined && value !== false) e.setAttribute(key, value === true ? '' : value);
    }
    e.append(...children.flat().filter(c => c !== null && c !== undefined));
    return e;
}
let tables = 0, figures = 0;
const caption = text => el('caption', {}, el('b', {}, `Table ${++tables}. `), text);
const figcaption = (...text) => el('figcaption', {}, el('b', {}, `Figure ${++figures}. `), ...text);

// 3.2 x 10^-6, or plain where that is short. null: a dash.
function number(x, digits = 3) {
    if (x === null || x === undefined) return '–';
    if (x === 0) return '0';
    const magnitude = Math.abs(x);
    if (magnitude >= 0.001 && magnitude < 10000) return String(Number(x.toPrecision(digits)));
    const [mantissa, exponent] = x.toExponential(digits - 1).split('e');
    return el('span', {class: 'power'}, `${Number(mantissa)}\u2009×\u200910`, el('sup', {}, String(Number(exponent)).replace('-', '−')));
}
// For tables: two digits, so that exponents stand below each other.
function brief(x) {
    if (x === null || x === undefined) return '–';
    if (x === 0) return '0';
    if (Math.abs(x) >= 0.0995) return String(Number(x.toPrecision(2)));
    const [mantissa, exponent] = x.toExponential(1).split('e');
    return el('span', {class: 'power'}, `${mantissa}\u2009×\u200910`, el('sup', {}, String(Number(exponent)).replace('-', '−')));
}
const plain = x => x === null || x === undefined ? '–' : x === 0 ? '0' : x >= 0.001 && x < 10000 ? String(Number(x.toPrecision(3))) : x.toExponential(1);

function command(line) {
    if (!line) return null;
    const button = el('button', {type: 'button', 'aria-label': 'copy the command', onclick: async () => {
        try { await navigator.clipboard.writeText(line); }
        catch (e) { // pages opened from a file may not have the clipboard
            const range = document.createRange();
            range.selectNodeContents(code);
            getSelection().removeAllRanges();
            getSelection().addRange(range);
            document.execCommand('copy');
        }
        said.textContent = 'copied';
        setTimeout(() => { said.textContent = 'copy'; }, 1500);
    }}, el('span', {'aria-live': 'polite'}, 'copy'));
    const said = button.firstChild;
    const code = el('code', {}, line);
    return el('div', {class: 'command'}, code, button);
}
const level = row => row.level === 0 ? 'level 0' : `level ${row.level}`;
const title = row => row.comparison === 'stage' ? `${row.scene}: the stage ${row.variant}` : `${row.scene}, ${level(row)}: ${row.a} against ${row.b}`;
const uncompared = row => row.verdict === 'not compared', style = verdict => verdict.replaceAll(' ', '-');
const ratio = (row, digits) => row.severity === null ? '∞' : row.severity < 0.01 ? '< 0.01' : row.severity < 1e4 ? String(Number(row.severity.toPrecision(digits))) : row.severity.toExponential(0);

// ---- head -------------------------------------------------------------------
$('verdict').classList.add(data.verdict === 'agree' ? 'good' : 'bad');
$('verdict').prepend(data.verdict === 'agree' ? '✓ ' : '✗ ');
{
    const parts = [];
    if (data.volume) parts.push(`Volume ${data.volume}`);
    if (data.scene) parts.push(`scene ${data.scene}`);
    parts.push(`made ${data.made.replace('T', ' ').replace('Z', ' UTC')}`);
    if (data.seconds.total) parts.push(`in ${Number(data.seconds.total.toPrecision(3))} s`);
    $('about').textContent = parts.join(', ') + '.';
    for (const [scene, asked] of Object.entries(data.asked || {}).filter(([, a]) => a.assumed)) $('about').after(el('p', {class: 'about assumed'}, `${scene}: ${asked.why}.`));
    if (data.command) $('again').append(command(data.command));
}

// ---- differences: 16 bits on a log scale in red and green ---------------------
const decodes = new Map();
function loadImage(uri) {
    return new Promise((resolve, reject) => {
        const image = new Image();
        image.onload = () => resolve(image);
        image.onerror = reject;
        image.src = uri;
    });
}
async function pixels(uri) {
    if (!decodes.has(uri)) decodes.set(uri, (async () => {
        const image = await loadImage(uri);
        const canvas = el('canvas', {width: image.width, height: image.height});
        const context = canvas.getContext('2d', {willReadFrequently: true});
        context.drawImage(image, 0, 0);
        return {canvas, width: image.width, height: image.height, bytes: context.getImageData(0, 0, image.width, image.height).data};
    })());
    return decodes.get(uri);
}
// log10 of the difference; -Infinity for none, Infinity for pixels that are not finite.
async function differences(key) {
    const p = await pixels(inlined.differences[key]);
    const logs = new Float32Array(p.width * p.height);
    for (let i = 0; i < logs.length; ++i) {
        const code = p.bytes[4 * i] * 256 + p.bytes[4 * i + 1];
        logs[i] = code === 0 ? -Infinity : code === 65535 ? Infinity : (code - 1) * 11 / 65533 - 9;
    }
    return {logs, width: p.width, height: p.height};
}
const stops = [[0, 8, 8, 24], [0.25, 72, 20, 110], [0.5, 176, 44, 104], [0.75, 244, 126, 60], [1, 252, 246, 190]];
const shades = 1024, colours = new Uint8ClampedArray(3 * (shades + 1));
for (let i = 0; i <= shades; ++i) {
    const t = i / shades;
    let k = 1;
    while (k < stops.length - 1 && t > stops[k][0]) ++k;
    const [t0, ...a] = stops[k - 1], [t1, ...b] = stops[k], f = (t - t0) / (t1 - t0);
    a.forEach((v, c) => { colours[3 * i + c] = v + f * (b[c] - v); });
}
const shadeOf = t => 3 * Math.round(Math.min(Math.max(t, 0), 1) * shades);
const scaleLow = -8, scaleHigh = 0; // one scale for all cases, so that they can be compared
// Above the threshold in colour; below it the image itself, grey and faint.
function paintDifference(d, under, threshold) {
    const canvas = el('canvas', {width: d.width, height: d.height}), context = canvas.getContext('2d');
    const out = context.createImageData(d.width, d.height);
    let above = 0;
    for (let i = 0, o = 0; i < d.logs.length; ++i, o += 4) {
        const log = d.logs[i];
        if (log === Infinity) out.data.set([0, 255, 255], o);
        else if (log > threshold) {
            const at = shadeOf((log - scaleLow) / (scaleHigh - scaleLow));
            for (let c = 0; c < 3; ++c) out.data[o + c] = colours[at + c];
        } else if (under) out.data.fill(0.12 * (under.bytes[o] + under.bytes[o + 1] + under.bytes[o + 2]) / 3, o, o + 3);
        out.data[o + 3] = 255;
        above += log > threshold;
    }
    context.putImageData(out, 0, 0);
    return {canvas, above};
}
function legend() {
    const width = 320, canvas = el('canvas', {width, height: 12, style: 'height:12px;width:320px', 'aria-hidden': 'true'});
    const context = canvas.getContext('2d');
    for (let x = 0; x < width; ++x) {
        context.fillStyle = `rgb(${colours.slice(shadeOf(x / (width - 1)), shadeOf(x / (width - 1)) + 3)})`;
        context.fillRect(x, 0, 1, 12);
    }
    const ticks = el('div', {style: 'display:flex;justify-content:space-between;width:320px;font:11px/1.4 var(--sans);color:var(--quiet)'});
    for (let e = scaleLow; e <= scaleHigh; e += 2) ticks.append(el('span', {}, e === 0 ? '1' : el('span', {}, '10', el('sup', {}, String(e).replace('-', '−')))));
    return el('div', {}, canvas, ticks);
}

// ---- tables -----------------------------------------------------------------
const cell = (content, numeric, extra) => el('td', {class: [numeric ? 'n' : '', extra || ''].join(' ').trim() || null}, content);
function table(text, heads, rows) {
    return el('div', {class: 'scroll'}, el('table', {}, caption(text),
        el('thead', {}, el('tr', {}, heads.map(([name, numeric]) => el('th', {class: numeric ? 'n' : null, scope: 'col'}, name)))),
        el('tbody', {}, rows)));
}
const withLimit = (row, key, value) => {
    const limit = row.limits[key];
    const over = !uncompared(row) && limit !== undefined && value !== null && !(value <= limit);
    return el('td', {class: over ? 'n differ' : 'n', title: limit === undefined ? 'no limit' : `limit ${plain(limit)}`}, brief(value));
};

const names = {rmse: 'RMSE', max_abs: 'max', p99_abs: 'p99', ssim_dissimilarity: '1 − SSIM', flip_mean: 'FLIP'};
function valueOf(row, key) {
    return key === 'ssim_dissimilarity' ? (row.ssim === null ? null : 1 - row.ssim) : row[key];
}
// All that is asked of a row, the worst first: limits of metrics, and gates.
function asked(row) {
    if (row.verdict === 'refused' || !row.image_b) return [];
    const all = Object.entries(row.limits).map(([key, limit]) => ({name: names[key], value: valueOf(row, key), limit}));
    for (const gate of row.gates || []) all.push(gate);
    return all.map(({gate, name, value, limit}) => ({gate, name, value, limit, held: value !== null && value <= limit,
        ratio: value === null ? Infinity : limit > 0 ? value / limit : value <= 0 ? 0 : Infinity})).sort((x, y) => y.ratio - x.ratio);
}
function explain(row) {
    if (row.verdict === 'refused') return ['Refused: ', row.why];
    if (row.nonfinite_count > 0) return [`${row.nonfinite_count} pixels are not finite. `, row.why || ''];
    const out = [], all = asked(row);
    for (const {name, value, limit} of all.filter(x => !x.held))
        out.push(`${name} is `, number(value), ...(limit > 0 && value !== null ? [`, ${plain(value / limit)} times its limit of `, number(limit)] : [', at most ', number(limit)]), '. ');
    if (all.length === 0) out.push('No limit was given, so only equal images agree. ');
    return [...out, row.why ? `Why this limit: ${row.why}` : ''];
}
const percent = x => x === Infinity ? '∞' : x < 0.01 ? '< 0.01' : plain(x);
function askedTable(row) {
    const all = asked(row);
    if (all.length === 0) return [];
    return [el('div', {class: 'scroll'}, el('table', {class: 'asked'}, el('thead', {}, el('tr', {}, ['what is asked', 'value', 'at most', 'of limit'].map((name, i) => el('th', {scope: 'col', class: i ? 'n' : null}, name)))),
        el('tbody', {}, all.map(x => el('tr', {}, cell(x.name), cell(number(x.value), true, x.held ? '' : 'differ'), cell(number(x.limit), true), cell(percent(x.ratio), true, x.held ? '' : 'differ'))))))];
}
// What the reference shows, beside what its limits ask for.
function signalText(row) {
    const s = row.signal;
    if (!s) return [];
    return [el('p', {}, `The reference shows ${s.measure === 'p99' ? 'in the brightest 1 % of its pixels' : '(RMS)'} `, number(s.color, 2), ' above its background in color and ', number(s.alpha, 2), ' in alpha; at least ', number(s.least, 2), ' is asked for.')];
}
// What the gates were taken from, in a sentence; the rest for those who ask.
function statisticsText(row) {
    const s = row.statistics;
    if (!s) return [];
    const out = [], step = x => x >= 1 ? plain(x) : `1/${plain(1 / x)}`;
    if (s.step_voxels) {
        out.push(`Extrapolated from steps of ${step(2 * s.step_voxels)} and ${step(s.step_voxels)} voxel, whose RMSE is `, number(s.rmse_at_twice_the_step, 2), ' and ', number(s.rmse_at_the_step, 2));
        if (s.order !== null) out.push(` (order ${plain(s.order)})`);
        out.push('. The finer image lies ', number(s.step_bar, 2), ' from the limit');
        if (s.seeds > 1) out.push(`; the noise of the mean over ${s.seeds} seeds is `, number(s.noise_bar, 2), ', its bias ', number(s.signed_bias, 2), ' ± ', number(s.standard_error_of_bias, 2), ', the mean local error ', number(s.mean_local_error, 2));
        const factor = row.error_bar / Math.hypot(s.step_bar, s.seeds > 1 ? s.noise_bar : 0);
        if (factor > 1.01) out.push(`; the error bar has a factor of safety of ${plain(factor)}`);
        out.push('.');
    }
    return [el('p', {}, out), el('details', {}, el('summary', {}, 'all its statistics'), el('dl', {class: 'statistics'}, Object.entries(s).map(([key, value]) =>
        [el('dt', {}, key.replaceAll('_', ' ')), el('dd', {}, typeof value === 'number' ? number(value) : value === null ? '–' : String(value))]).flat()))];
}

// ---- the table of agreement: sorted and filtered by its reader --------------------
const renderer = row => row.renderer;
const severityOf = row => uncompared(row) ? -1 : row.severity ?? Infinity;
const verdicts = ['agree', 'not compared', 'refused', 'differ'];
// heading, what it sorts by (numbers: the largest first), numeric
const columns = [['verdict', row => verdicts.indexOf(row.verdict) * 1e3 + Math.min(severityOf(row), 900)], ['of limit', severityOf, true],
    ['level', row => row.level, true], ['scene', row => row.scene], ['b against a', row => row.b],
    ['RMSE', row => row.rmse, true], ['error bar', row => row.error_bar, true], ['max', row => row.max_abs, true], ['p99', row => row.p99_abs, true],
    ['1 − SSIM', row => valueOf(row, 'ssim_dissimilarity'), true], ['FLIP', row => row.flip_mean, true], ['seconds', row => row.seconds, true]]
    .filter(([name]) => name !== 'seconds' || data.agreement.some(row => row.seconds));
const filters = [['verdict', row => row.verdict], ['renderer', renderer], ['level', row => String(row.level)], ['tier', row => row.tier || ''], ['scene', row => row.scene]];
const order = {rows: data.agreement.map((row, at) => at), column: -1, down: true, filter: {}, text: ''};
let agreement = null;

// What comes nearest to its limit, in a word; gates have longer names.
const words = {error_bar: 'bar', halving: 'halving', pixels: 'pixels', bias: 'bias'};
function agreementRow(row, at) {
    const open = el('button', {type: 'button', class: 'open', onclick: e => { e.stopPropagation(); inspect(at, true); }}, row.scene);
    const worst = asked(row)[0];
    const limit = el('td', {class: 'n', title: worst ? `${worst.name}: ${plain(worst.value)}, at most ${plain(worst.limit)}` : null},
        uncompared(row) ? '–' : [worst ? el('small', {}, `${words[worst.gate] || worst.name} `) : '', ratio(row, 2)]);
    const seconds = columns.at(-1)[0] === 'seconds' ? cell(row.seconds ? String(Number(row.seconds.toPrecision(2))) : '–', true) : null;
    return el('tr', {class: row.image_a && row.image_b ? 'pick' : null, id: `row-${row.number}`, onclick: () => { if (!String(getSelection())) inspect(at, true); }},
        cell(row.verdict, false, style(row.verdict)), limit, cell(String(row.level), true),
        cell([row.image_a && row.image_b ? open : row.scene, row.tier ? el('small', {}, ` ${row.tier}`) : '']), el('td', {class: 'pair'}, row.b, el('small', {}, row.a ? ` ${row.a}` : '')),
        withLimit(row, 'rmse', row.rmse), cell(brief(row.error_bar), true, (row.gates || []).some(g => g.gate === 'error_bar' && !(g.value <= g.limit)) ? 'differ' : ''), withLimit(row, 'max_abs', row.max_abs), withLimit(row, 'p99_abs', row.p99_abs),
        withLimit(row, 'ssim_dissimilarity', valueOf(row, 'ssim_dissimilarity')), withLimit(row, 'flip_mean', row.flip_mean), seconds || []);
}
function arrange() {
    const wanted = order.text.toLowerCase().split(/\s+/).filter(Boolean);
    const passes = row => filters.every(([name, of]) => !order.filter[name] || of(row) === order.filter[name]) &&
        wanted.every(w => `${row.scene} level ${row.level} ${row.tier || ''} ${row.a || ''} ${row.b} ${row.verdict}`.toLowerCase().includes(w));
    order.rows = data.agreement.map((row, at) => at).filter(at => passes(data.agreement[at]));
    if (order.column >= 0) {
        const key = at => columns[order.column][1](data.agreement[at]) ?? -Infinity, sign = order.down ? -1 : 1;
        order.rows.sort((x, y) => sign * (typeof key(x) === 'string' ? key(x).localeCompare(key(y)) : key(x) === key(y) ? 0 : key(x) < key(y) ? -1 : 1) || x - y);
    }
    agreement.body.replaceChildren(...order.rows.map(at => agreement.rows[at]));
    agreement.count.textContent = order.rows.length === data.agreement.length ? `${order.rows.length} cases` : `${order.rows.length} of ${data.agreement.length} cases`;
    agreement.heads.forEach((th, i) => th.setAttribute('aria-sort', i !== order.column ? 'none' : order.down ? 'descending' : 'ascending'));
}
function agreementFilters() {
    const selects = filters.map(([name, of]) => {
        const values = [...new Set(data.agreement.map(of))].filter(Boolean).sort((x, y) => x.localeCompare(y, undefined, {numeric: true}));
        if (values.length < 2) return null;
        return el('label', {}, name, el('select', {'data-filter': name, onchange: e => { order.filter[name] = e.target.value; arrange(); }},
            el('option', {value: ''}, 'all'), values.map(v => el('option', {value: v}, v))));
    });
    const text = el('input', {type: 'search', placeholder: 'search', 'aria-label': 'rows with these words', oninput: () => { order.text = text.value; arrange(); }});
    const all = el('button', {type: 'button', onclick: () => {
        order.filter = {}; order.text = text.value = ''; order.column = -1;
        for (const select of controls.querySelectorAll('select')) select.value = '';
        arrange();
    }}, 'all, worst first');
    const controls = el('div', {class: 'controls'}, text, selects, all, agreement.count);
    return controls;
}
function agreementTable() {
    if (data.agreement.length === 0) return [el('p', {}, 'Nothing was compared.')];
    agreement = {rows: data.agreement.map(agreementRow), body: el('tbody', {}), count: el('output', {class: 'count'})};
    agreement.heads = columns.map(([name, , numeric], i) => el('th', {class: numeric ? 'n' : null, scope: 'col', 'data-name': name}, el('button', {type: 'button', class: 'sort', onclick: () => {
        order.down = order.column === i ? !order.down : Boolean(numeric) || name === 'verdict';
        order.column = i;
        arrange();
    }}, name)));
    const out = [agreementFilters(), el('p', {class: 'caption', id: 'agreement-caption'}, el('b', {}, `Table ${++tables}. `),
        'Agreement. Figures outside their limit are red; a limit shows when the pointer rests on its figure, and below the images of a case.'),
        el('div', {class: 'scroll tall', tabindex: 0, role: 'region', 'aria-label': 'table of agreement'},
        el('table', {'aria-labelledby': 'agreement-caption'}, el('thead', {}, el('tr', {}, agreement.heads)), agreement.body))];
    arrange();
    return out;
}

// ---- panels of failed cases ---------------------------------------------------
function still(uri, name, note) {
    return el('div', {class: 'panel'}, el('img', {src: uri, alt: name}), el('span', {}, el('strong', {}, name), note ? ` ${note}` : ''));
}
async function differencePanel(row) {
    const holder = el('div', {class: 'panel'});
    const d = await differences(row.number), {canvas} = paintDifference(d, null, -Infinity);
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', 'difference');
    canvas.style.cursor = 'default';
    holder.append(canvas, el('span', {}, el('strong', {}, 'difference'), ' log scale, 10⁻⁸ to 1'));
    return holder;
}
function failures() {
    const bad = data.agreement.filter(row => row.verdict === 'differ'), shown = 8, reasons = new Map();
    for (const row of data.agreement.filter(r => r.verdict === 'refused')) reasons.set(row.why, [...reasons.get(row.why) || [], row]);
    const unfit = data.calibration.filter(r => r.verdict === 'fail' && !(r.value === null && reasons.has(r.detail))); // a missing renderer is told once
    if (bad.length + reasons.size + unfit.length === 0) return;
    $('failed').hidden = false;
    for (const row of bad.slice(0, shown)) {
        const panels = el('div', {class: 'panels'});
        if (row.image_a) panels.append(still(inlined.images[row.image_a], row.a, 'a'));
        if (row.image_b) panels.append(still(inlined.images[row.image_b], row.b, 'b'));
        if (inlined.differences[row.number]) differencePanel(row).then(p => panels.append(p));
        $('failed').append(el('div', {class: 'failure'}, el('h3', {}, title(row)), el('p', {}, explain(row)), panels, command(row.command) || '',
            inlined.differences[row.number] ? el('button', {type: 'button', onclick: () => inspect(data.agreement.indexOf(row), true)}, 'look closer') : null));
    }
    if (bad.length > shown) $('failed').append(el('p', {}, `${bad.length - shown} more that differ stand in the table below.`));
    for (const r of unfit)
        $('failed').append(el('div', {class: 'failure'}, el('h3', {}, `Calibration of ${r.renderer}: ${r.check}`),
            el('p', {}, r.value === null ? 'Nothing could be measured. ' : [number(r.value), ` ${r.unit || ''}, at most `, number(r.limit), '. '], r.detail || '')));
    for (const [why, rows] of reasons)
        $('failed').append(el('div', {class: 'failure'}, el('h3', {}, `${rows.length} case${rows.length === 1 ? '' : 's'} refused: ${[...new Set(rows.map(renderer))].join(', ')}`), el('p', {}, why),
            el('details', {}, el('summary', {}, 'which'), el('ul', {}, rows.map(row => el('li', {}, title(row)))))));
}

// What nobody compared, by the reason: a sentence with the row's own numbers stands beside each.
const reasons = {signal: 'show too little for their limits', trait: 'ask for what the renderer does not have', stage: 'did not run'};
function notCompared() {
    const groups = new Map();
    for (const row of data.agreement.filter(uncompared)) groups.set(row.not_compared, [...groups.get(row.not_compared) || [], row]);
    $('uncompared').hidden = groups.size === 0;
    for (const [reason, rows] of groups)
        $('uncompared').append(el('details', {open: rows.length <= 8}, el('summary', {}, `${rows.length} ${reason === 'stage' ? 'stage' : 'case'}${rows.length === 1 ? '' : 's'}: ${reasons[reason] || reason}`),
            el('ul', {}, rows.map(row => el('li', {}, `${title(row)}: ${row.why}.`)))));
}

// ---- inspector ----------------------------------------------------------------
const cases = data.agreement.map((row, at) => ({row, at})).filter(c => c.row.image_a && c.row.image_b);
const view = {at: -1, mode: 'side', flip: 'a', threshold: -5, zoom: 1, x: 0.5, y: 0.5, timer: 0};
let parts = null;

function buildInspector() {
    const section = $('inspector');
    section.hidden = false;
    const select = el('select', {'aria-label': 'case', onchange: () => inspect(Number(select.value), false)},
        cases.map(c => el('option', {value: c.at}, `${c.row.verdict}: ${title(c.row)}`)));
    const walk = el('span', {class: 'group'}, el('button', {type: 'button', onclick: () => next(-1)}, '‹ previous'), el('button', {type: 'button', onclick: () => next(1)}, 'next ›'));
    const modes = {side: 'side by side', flip: 'flip A/B', difference: 'difference'};
    const buttons = Object.entries(modes).map(([mode, name]) => el('button', {type: 'button', 'data-mode': mode, onclick: () => { view.mode = mode; show(); }}, name));
    const flipButton = el('button', {type: 'button', onclick: swap}, 'swap (space)');
    const auto = el('button', {type: 'button', 'aria-pressed': 'false', onclick: () => {
        if (view.timer) { clearInterval(view.timer); view.timer = 0; } else view.timer = setInterval(swap, 500);
        auto.setAttribute('aria-pressed', String(view.timer !== 0));
    }}, 'twice a second');
    const slider = el('input', {type: 'range', min: -9, max: 0, step: 0.05, 'aria-label': 'threshold', oninput: () => { view.threshold = Number(slider.value); show(); }});
    const value = el('output', {});
    const zoomTo = factor => { view.zoom = Math.min(Math.max(view.zoom * factor, 1), 64); clampView(); show(); };
    const reset = () => zoomTo(0);
    const panel = name => {
        const canvas = el('canvas', {tabindex: 0, role: 'img', 'aria-label': name});
        const label = el('span', {'aria-live': 'polite'});
        attachPointer(canvas);
        return {box: el('div', {class: 'panel'}, canvas, label), canvas, label};
    };
    parts = {select, slider, value, a: panel('image a'), b: panel('image b'), d: panel('difference'),
        flipGroup: el('span', {class: 'group'}, flipButton, auto), thresholdGroup: el('label', {}, 'differences above', slider, value),
        panels: el('div', {class: 'panels'}), readout: el('p', {class: 'readout'}, '\u00a0'), text: el('div', {}), buttons};
    parts.panels.append(parts.a.box, parts.b.box, parts.d.box);
    section.append(el('div', {class: 'controls'}, walk, select), el('div', {class: 'controls'}, el('span', {class: 'group'}, buttons), parts.flipGroup, parts.thresholdGroup,
        el('span', {class: 'group'}, el('button', {type: 'button', 'aria-label': 'zoom in', onclick: () => zoomTo(1.5)}, '+'),
            el('button', {type: 'button', 'aria-label': 'zoom out', onclick: () => zoomTo(1 / 1.5)}, '−'), el('button', {type: 'button', onclick: reset}, 'whole'))),
        el('figure', {}, parts.panels, parts.readout, legend(), figcaption('The two images and the largest difference of their channels at each pixel, on one log scale for all cases; cyan marks pixels that are not finite. ' +
            'All panels zoom (wheel) and move (drag) in step; a double click shows the whole image. Keys: f flips, space swaps, s side by side, d difference, ' +
            'n and p the next and the previous case of the table, + − 0 and arrows zoom and move. Panels are 8-bit; the .exr files in images/ are what was compared.')), parts.text);
    const move = (x, y) => { view.x += x / view.zoom; view.y += y / view.zoom; clampView(); show(); };
    const mode = name => { view.mode = name; show(); };
    const keys = {f: () => view.mode === 'flip' ? swap() : mode('flip'), s: () => mode('side'), d: () => mode('difference'), n: () => next(1), p: () => next(-1),
        '+': () => zoomTo(1.5), '=': () => zoomTo(1.5), '-': () => zoomTo(1 / 1.5), 0: reset};
    const arrows = {ArrowLeft: () => move(-0.1, 0), ArrowRight: () => move(0.1, 0), ArrowUp: () => move(0, -0.1), ArrowDown: () => move(0, 0.1)};
    document.addEventListener('keydown', e => {
        const on = document.activeElement, inside = section.contains(on);
        if (e.ctrlKey || e.altKey || e.metaKey || /^(INPUT|SELECT|TEXTAREA)$/.test(on.tagName)) return;
        // Space presses the button that has the focus; the one that chose to flip goes on flipping.
        const swaps = e.key === ' ' && view.mode === 'flip' && (on === document.body || on.tagName === 'CANVAS' || on.dataset.mode === 'flip');
        const act = swaps ? swap : keys[e.key] || (inside && on.tagName === 'CANVAS' && view.zoom > 1 ? arrows[e.key] : null);
        if (act) { e.preventDefault(); act(); }
    });
    addEventListener('hashchange', followHash);
    addEventListener('resize', show);
}
// The case after this one in the table, as its reader has arranged it.
function next(step) {
    const list = order.rows.filter(at => cases.some(c => c.at === at)), here = list.indexOf(view.at);
    if (list.length) inspect(list[here < 0 ? 0 : (here + step + list.length) % list.length], false);
}
function swap() { view.flip = view.flip === 'a' ? 'b' : 'a'; show(); }
function clampView() {
    const half = 0.5 / view.zoom;
    view.x = Math.min(Math.max(view.x, half), 1 - half);
    view.y = Math.min(Math.max(view.y, half), 1 - half);
}
function attachPointer(canvas) {
    let drag = null;
    const place = e => {
        const r = canvas.getBoundingClientRect();
        return {u: view.x + ((e.clientX - r.left) / r.width - 0.5) / view.zoom, v: view.y + ((e.clientY - r.top) / r.height - 0.5) / view.zoom, r};
    };
    canvas.addEventListener('wheel', e => {
        if (e.deltaY > 0 && view.zoom === 1) return; // nothing to zoom out of: the page scrolls
        e.preventDefault();
        const before = place(e), zoom = Math.min(Math.max(view.zoom * Math.exp(-e.deltaY * 0.002), 1), 64);
        view.x = before.u + (view.x - before.u) * view.zoom / zoom;
        view.y = before.v + (view.y - before.v) * view.zoom / zoom;
        view.zoom = zoom;
        clampView();
        show();
    }, {passive: false});
    canvas.addEventListener('pointerdown', e => { drag = {x: e.clientX, y: e.clientY}; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener('pointerup', () => { drag = null; });
    canvas.addEventListener('dblclick', () => { view.zoom = 1; clampView(); show(); });
    canvas.addEventListener('pointermove', e => {
        const p = place(e);
        if (drag) {
            view.x -= (e.clientX - drag.x) / p.r.width / view.zoom;
            view.y -= (e.clientY - drag.y) / p.r.height / view.zoom;
            drag = {x: e.clientX, y: e.clientY};
            clampView();
            show();
        }
        readout(p.u, p.v);
    });
}
let loaded = null;
function readout(u, v) {
    if (!loaded) return;
    const {a, b, d} = loaded, x = Math.floor(u * a.width), y = Math.floor(v * a.height);
    if (x < 0 || y < 0 || x >= a.width || y >= a.height) return;
    const i = y * a.width + x, rgb = p => Array.from(p.bytes.slice(4 * i, 4 * i + 3)).join(' ');
    const log = d.logs[i], text = log === Infinity ? 'not finite' : log === -Infinity ? '0' : (10 ** log).toExponential(2);
    parts.readout.textContent = `column ${x}, row ${y}:  a ${rgb(a)}   b ${rgb(b)} (sRGB)   difference ${text}`;
}
// Draws the part in view, with square pixels once they are large.
function draw(panel, source, name, note) {
    const width = Math.max(Math.round(panel.canvas.clientWidth * (devicePixelRatio || 1)), 64);
    const height = Math.round(width * source.height / source.width);
    panel.canvas.width = width;
    panel.canvas.height = height;
    const context = panel.canvas.getContext('2d'), scale = width / source.width * view.zoom;
    context.imageSmoothingEnabled = scale < 1;
    context.drawImage(source, width / 2 - view.x * source.width * scale, height / 2 - view.y * source.height * scale, source.width * scale, source.height * scale);
    panel.label.replaceChildren(el('strong', {}, name), note ? ` ${note}` : '');
}
function show() {
    if (!loaded) return;
    const {row, a, b, d} = loaded, side = view.mode === 'side', flip = view.mode === 'flip';
    for (const button of parts.buttons) button.setAttribute('aria-pressed', String(button.dataset.mode === view.mode));
    parts.panels.classList.toggle('one', !side);
    parts.flipGroup.hidden = !flip;
    parts.thresholdGroup.hidden = flip;
    parts.a.box.hidden = !(side || (flip && view.flip === 'a'));
    parts.b.box.hidden = !(side || (flip && view.flip === 'b'));
    parts.d.box.hidden = flip;
    parts.slider.value = view.threshold;
    parts.value.replaceChildren(view.threshold <= -9 ? 'any' : brief(10 ** view.threshold));
    if (!parts.a.box.hidden) draw(parts.a, a.canvas, row.a, 'a');
    if (!parts.b.box.hidden) draw(parts.b, b.canvas, row.b, 'b');
    if (!parts.d.box.hidden) {
        const threshold = view.threshold <= -9 ? -Infinity : view.threshold;
        if (!loaded.painted || loaded.painted.threshold !== threshold) loaded.painted = {threshold, ...paintDifference(d, a, threshold)};
        const {canvas, above} = loaded.painted;
        draw(parts.d, canvas, 'difference', `${above} of ${d.logs.length} pixels (${Number((100 * above / d.logs.length).toPrecision(3))} %) above`);
    }
}
async function inspect(at, scroll) {
    const row = data.agreement[at];
    if (!parts || !row.image_a || !row.image_b) return;
    agreement.rows.forEach((tr, i) => { tr.classList.toggle('chosen', i === at); i === at ? tr.setAttribute('aria-current', 'true') : tr.removeAttribute('aria-current'); });
    view.at = at;
    const [a, b, d] = await Promise.all([pixels(inlined.images[row.image_a]), pixels(inlined.images[row.image_b]), differences(row.number)]);
    if (view.at !== at) return; // another case was chosen meanwhile
    loaded = {row, a, b, d};
    parts.select.value = String(at);
    // Where all is within the limits, all differences show; else those beyond the limit.
    const gate = row.verdict !== 'differ' ? 1e-9 : row.limits.max_abs ?? row.limits.p99_abs ?? row.limits.rmse ?? 1e-5;
    view.threshold = Math.min(Math.max(Math.round(Math.log10(gate) * 20) / 20, -9), 0);
    parts.text.replaceChildren(el('p', {}, el('span', {class: style(row.verdict)}, row.verdict), row.tier ? `, tier ${row.tier}` : '', row.why ? `: ${row.why}` : '', '. ',
        `Worst pixel: column ${row.worst_pixel[0]}, row ${row.worst_pixel[1]}.`), ...askedTable(row), ...signalText(row), ...statisticsText(row), command(row.command) || '');
    // The address names the case, so that it can be passed on.
    if (scroll !== null && location.hash !== `#case-${row.number}`) history.replaceState(null, '', `#case-${row.number}`);
    show();
    if (scroll) $('inspector').scrollIntoView({behavior: matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth'});
}
// #case-12, or #case-12-flip to begin with; scrolls there.
function followHash() {
    const wanted = /^#case-(\d+)(?:-(side|flip|difference))?$/.exec(location.hash);
    const found = wanted ? cases.find(c => c.row.number === Number(wanted[1])) : null;
    if (wanted && wanted[2]) view.mode = wanted[2];
    if (found) inspect(found.at, true);
    return Boolean(found);
}

// ---- levels ---------------------------------------------------------------------
const wayOf = r => `${r.method === 'on-the-fly' ? 'gradients on the fly' : r.method}, ${r.tf} TF`;
// The difference of the default to another way, with half of its interval; ahead and behind as they were judged.
function against(row, way, key) {
    const f = way.figures.find(x => x.figure === key), margin = Math.max(row.margin, f.half_width ?? Infinity);
    const word = f.better ? 'behind' : -f.difference > margin ? 'ahead' : 'within the scatter';
    const plusMinus = f.half_width === null ? ', one view' : ` ± ${plain(f.half_width)}`;
    return {text: `${f.difference < 0 ? '−' : '+'}${plain(Math.abs(f.difference))}${plusMinus}`, word, f};
}
function levelVerdicts() {
    const rows = data.levels || [];
    if (rows.length === 0) return;
    const good = rows.every(r => r.verdict === 'agree');
    $('levels').hidden = $('levels-verdict').hidden = false;
    $('levels-verdict').textContent = `${good ? '✓' : '✗'} ${data.levels_sentence}`;
    $('levels-verdict').classList.add(good ? 'good' : 'bad');
    const lines = [];
    for (const row of rows) row.figures.forEach((f, i) => {
        const simple = against(row, row.simple, f.figure);
        // The other method that is nearest to level 0 by this figure, ahead or not.
        const best = [...row.rivals].sort((a, b) => a.figures[i].value - b.figures[i].value)[0];
        const rival = best ? against(row, best, f.figure) : null;
        lines.push(el('tr', {'data-level': row.level, 'data-verdict': row.verdict}, cell(i ? '' : String(row.level), true), cell(i ? '' : row.verdict, false, i ? '' : row.verdict),
            cell(i ? '' : wayOf(row)), cell(f.name), cell(number(f.value), true, f.held ? '' : 'differ'), cell(f.asked === null ? 'not asked' : number(f.asked), true),
            cell(`${simple.text}, ${simple.word}`, true, simple.word === 'behind' ? 'differ' : ''),
            cell(rival ? `${wayOf(best)}: ${rival.text}, ${rival.word}` : '–', false, rival && rival.word === 'behind' ? 'named' : '')));
    });
    $('levels').append(table(`Levels. Differences are the default's figure less the other's, means over ${rows[0].views} views with half of the ${plain(100 * rows[0].confidence)} % interval; ` +
        `below a margin of ${plain(rows[0].margin)} nobody sees one.${rows[0].views < 6 ? ' So few views have wide intervals.' : ''}`,
        [['level', 1], ['verdict'], ['default'], ['figure'], ['value', 1], ['at most', 1], ['to the simple way', 1], ['to the nearest of the others']], lines));
    const options = rows.flatMap(r => r.rivals.filter(x => x.better).map(x => el('li', {}, `Level ${r.level}: ${wayOf(x)}, by ${x.figures.filter(f => f.better).map(f => `${f.name} (${plain(f.value)} against ${plain(f.value + f.difference)})`).join(' and ')}: `, el('code', {}, x.option))));
    if (options.length) $('levels').append(el('p', {}, 'Ahead of the default in a figure, beyond the scatter, and behind it in none:'), el('ul', {class: 'rivals'}, options));
    const wrong = rows.filter(r => !r.stored.held);
    $('levels').append(el('p', {}, wrong.length === 0 ? 'Every level was made again from level 0 and is the one that is stored.' :
        wrong.map(r => `Level ${r.level} is not what level 0 makes: its values are off by up to ${plain(r.stored.scalar)} of their range, its directions by ${plain(r.stored.direction_deg)} degrees on average. `)));
}

// ---- consistency, calibration, colophon ----------------------------------------
function consistency() {
    if (data.consistency.length === 0) return;
    const section = $('consistency'), levels = [...new Set(data.consistency.map(r => r.level))].sort((a, b) => a - b);
    section.hidden = false;
    if (inlined.charts.consistency) section.append(el('figure', {}, el('img', {src: inlined.charts.consistency, alt: 'error against level 0 for each level and method'}),
        figcaption('Error against level 0 for each level and method. Data and script: charts/consistency.csv, charts/consistency.gp.')));
    const keys = ['ssim_dissimilarity_mean', 'flip_mean', 'rmse_mean', 'gradient_angle_mean_deg', 'gradient_angle_p95_deg'].filter(key => data.consistency.some(r => key in r)), rows = [];
    const heads = {ssim_dissimilarity_mean: '1 − SSIM', flip_mean: 'FLIP', rmse_mean: 'RMSE', gradient_angle_mean_deg: 'direction, mean °', gradient_angle_p95_deg: 'direction, 95 % °'};
    const tf = r => r.tf === 'adapted' ? 'adapted' : 'original', adapted = data.consistency.some(r => tf(r) === 'adapted');
    for (const k of levels) {
        const group = data.consistency.filter(r => r.level === k);
        const best = keys.map(key => Math.min(...group.map(r => r[key]).filter(v => v !== null)));
        for (const r of group) rows.push(el('tr', {'data-tf': tf(r)}, cell(String(r.level), true), cell(r.method),
            adapted ? cell([tf(r), r.original_kept ? el('small', {class: 'reported', title: r.original_kept}, ' refused, original kept') : '']) : null, cell(String(r.views), true),
            keys.map((key, i) => cell(number(r[key]), true, group.length > 1 && r[key] === best[i] ? 'best' : ''))));
    }
    section.append(table('Consistency: error against level 0.', [['level', 1], ['method'], ...(adapted ? [['TF']] : []), ['views', 1], ...keys.map(key => [heads[key], 1])], rows));
    const kept = new Map(data.consistency.filter(r => r.original_kept).map(r => [r.level, r.original_kept]));
    for (const [k, why] of kept) section.append(el('p', {class: 'kept'}, `Level ${k}: adapting was refused. ${why[0].toUpperCase()}${why.slice(1)}.`));
    const pictured = data.consistency.filter(r => r.image), shown = levels.filter(k => pictured.some(r => r.level === k));
    if (pictured.length === 0) return;
    // One row a level and TF, one column a method: what is to be compared stands side by side.
    const methods = [...new Set(pictured.map(r => r.method))], reference = pictured[0].reference_image;
    const panels = el('div', {class: 'levels', style: `grid-template-columns: repeat(${methods.length + 1}, minmax(0, 190px))`});
    let first = true;
    for (const k of shown) for (const which of ['original', 'adapted']) {
        const of = method => pictured.find(r => r.level === k && r.method === method && tf(r) === which);
        if (methods.every(m => !of(m) || of(m).original_kept)) continue; // nothing to see that was not seen above
        panels.append(first && reference ? still(inlined.images[reference], 'level 0') : el('div', {}));
        first = false;
        for (const method of methods) {
            const r = of(method);
            panels.append(r ? still(inlined.images[r.image], `level ${k}, ${method}`, `${which === 'adapted' ? (r.original_kept ? 'original TF kept, ' : 'adapted TF, ') : ''}1 − SSIM ${plain(r.ssim_dissimilarity_mean)}`) : el('div', {}));
        }
    }
    section.append(el('figure', {}, panels, figcaption('One view at each level (rows), with each way to shade it (columns); figures are means over all views.')));
}
function calibration() {
    if (data.calibration.length === 0) return;
    $('calibration').hidden = false;
    const rows = [...data.calibration].sort((a, b) => (a.verdict === 'fail' ? 0 : 1) - (b.verdict === 'fail' ? 0 : 1))
        .map(r => el('tr', {}, cell(r.renderer), cell(r.check), cell(number(r.value), true), cell(number(r.limit), true), cell(r.unit || ''), cell(r.verdict, false, r.verdict), cell(r.detail || '')));
    $('calibration').append(table('Calibration of each renderer.', [['renderer'], ['check'], ['value', 1], ['limit', 1], ['unit'], ['verdict'], ['']], rows));
}
function colophon() {
    const facts = el('div', {class: 'facts'});
    const show = value => typeof value === 'number' ? (Number.isInteger(value) ? String(value) : String(Number(value.toPrecision(4)))) : typeof value === 'string' ? value : Array.isArray(value) ? value.join(' × ') : typeof value === 'boolean' ? (value ? 'yes' : 'no') : JSON.stringify(value);
    for (const [key, name] of [['versions', 'Versions'], ['machine', 'Machine'], ['options', 'Options'], ['seconds', 'Seconds']]) {
        const entries = Object.entries(data[key] || {});
        if (entries.length === 0) continue;
        facts.append(el('div', {}, el('h3', {}, name), el('table', {}, el('tbody', {}, entries.map(([k, v]) => el('tr', {}, k === 'memory_bytes' ? [cell('memory'), cell(`${(v / 2 ** 30).toFixed(1)} GiB`)] : [cell(k.replaceAll('_', ' ')), cell(show(v))]))))));
    }
    $('colophon').append(facts);
}

failures();
notCompared();
if (data.charts_missing) $('agreement').append(el('p', {class: 'refused'}, `No charts: ${data.charts_missing}`));
$('agreement').append(...agreementTable());
if (cases.length > 0) {
    buildInspector();
    if (!followHash()) inspect(cases[0].at, null);
}
if (inlined.charts.agreement) $('chart').append(el('figure', {}, el('img', {src: inlined.charts.agreement, alt: 'RMSE of each comparison with its limit'}),
    figcaption('RMSE of each comparison on a log axis, the 40 worst at most. Data and script: charts/agreement.csv, charts/agreement.gp; charts/style.gp restyles all charts.')));
levelVerdicts();
consistency();
calibration();
colophon();
document.documentElement.dataset.ready = 'yes';
})();
