// SPDX-License-Identifier: MIT
// Tables of compared and other cases, and panels of cases that differ.
const withLimit = (row, key, value) => {
    const limit = row.limits[key];
    const over = !uncompared(row) && limit !== undefined && value !== null && !(value <= limit);
    return el('td', {class: over ? 'n differ' : 'n', title: limit === undefined ? 'no limit' : `limit ${plain(limit)}`}, brief(value));
};

function valueOf(row, key) {
    return key === 'ssim_dissimilarity' ? (row.ssim === null ? null : 1 - row.ssim) : row[key];
}
// All limits of a row, the worst first: metrics and gates.
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
    return [scroller('figures and limits', el('table', {class: 'asked'}, el('thead', {}, el('tr', {}, ['figure', 'value', 'at most', 'of limit'].map((name, i) => el('th', {scope: 'col', class: i ? 'n' : null}, name)))),
        el('tbody', {}, all.map(x => el('tr', {}, cell(x.name), cell(number(x.value), true, x.held ? '' : 'differ'), cell(number(x.limit), true), cell(percent(x.ratio), true, x.held ? '' : 'differ'))))))];
}
// Signal of the reference, and the least that its limits need.
function signalText(row) {
    const s = row.signal;
    if (!s) return [];
    return [el('p', {}, `The reference shows ${s.measure === 'p99' ? 'in the brightest 1 % of its pixels' : '(RMS)'} `, number(s.color, 2), ' above its background in color and ', number(s.alpha, 2), ' in alpha; needed is at least ', number(s.least, 2), '.')];
}
// Source of the gates, as a sentence; the other statistics are folded.
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

// ---- the table of agreement, which readers sort and filter --------------------
const renderer = row => row.renderer;
const severityOf = row => uncompared(row) ? -1 : row.severity ?? Infinity;
const verdicts = ['agree', 'not compared', 'refused', 'differ'];
// heading, sort key (numbers: the largest first), numeric
const columns = [['verdict', row => verdicts.indexOf(row.verdict) * 1e3 + Math.min(severityOf(row), 900)], ['of limit', severityOf, true],
    ['level', row => row.level, true], ['scene', row => row.scene], ['b against a', nameOf],
    ['RMSE', row => row.rmse, true], ['error bar', row => row.error_bar, true], ['max', row => row.max_abs, true], ['p99', row => row.p99_abs, true],
    ['1 − SSIM', row => valueOf(row, 'ssim_dissimilarity'), true], ['FLIP', row => row.flip_mean, true], ['seconds', row => row.seconds, true]]
    .filter(([name]) => name !== 'seconds' || data.agreement.some(row => row.seconds));
const filters = [['verdict', row => row.verdict], ['renderer', renderer], ['level', row => String(row.level)], ['tier', row => row.tier || ''], ['scene', row => row.scene]];
const order = {rows: data.agreement.map((row, at) => at), column: -1, down: true, filter: {}, text: ''};
let agreement = null;

// Short names of gates.
const words = {error_bar: 'bar', halving: 'halving', pixels: 'pixels', bias: 'bias'};
function agreementRow(row, at) {
    const open = el('button', {type: 'button', class: 'open', onclick: e => { e.stopPropagation(); inspect(at, true); }}, row.scene);
    const worst = asked(row)[0];
    const limit = el('td', {class: 'n', title: worst ? `${worst.name}: ${plain(worst.value)}, at most ${plain(worst.limit)}` : null},
        uncompared(row) ? '–' : [worst ? el('small', {}, `${words[worst.gate] || worst.name} `) : '', ratio(row, 2)]);
    const seconds = columns.at(-1)[0] === 'seconds' ? cell(row.seconds ? String(Number(row.seconds.toPrecision(2))) : '–', true) : null;
    return el('tr', {class: row.image_a && row.image_b ? 'pick' : null, id: `row-${row.number}`, onclick: () => { if (!String(getSelection())) inspect(at, true); }},
        cell(row.verdict, false, style(row.verdict)), limit, cell(String(row.level), true),
        cell([row.image_a && row.image_b ? open : row.scene, row.tier ? el('small', {}, ` ${row.tier}`) : ''], false, 'two-lines'), el('td', {class: 'pair two-lines'}, nameOf(row), el('small', {}, row.a ? ` ${row.a}` : '')),
        withLimit(row, 'rmse', row.rmse), cell(brief(row.error_bar), true, (row.gates || []).some(g => g.gate === 'error_bar' && !(g.value <= g.limit)) ? 'differ' : ''), withLimit(row, 'max_abs', row.max_abs), withLimit(row, 'p99_abs', row.p99_abs),
        withLimit(row, 'ssim_dissimilarity', valueOf(row, 'ssim_dissimilarity')), withLimit(row, 'flip_mean', row.flip_mean), seconds || []);
}
function arrange() {
    const wanted = order.text.toLowerCase().split(/\s+/).filter(Boolean);
    const passes = row => filters.every(([name, of]) => !order.filter[name] || of(row) === order.filter[name]) &&
        wanted.every(w => `${row.scene} level ${row.level} ${row.tier || ''} ${row.a || ''} ${row.b} ${nameOf(row)} ${row.verdict}`.toLowerCase().includes(w));
    order.rows = data.agreement.map((row, at) => at).filter(at => passes(data.agreement[at]));
    if (order.column >= 0) {
        const key = at => columns[order.column][1](data.agreement[at]) ?? -Infinity, sign = order.down ? -1 : 1;
        order.rows.sort((x, y) => sign * (typeof key(x) === 'string' ? key(x).localeCompare(key(y)) : key(x) === key(y) ? 0 : key(x) < key(y) ? -1 : 1) || x - y);
    }
    agreement.body.replaceChildren(...order.rows.map(at => agreement.rows[at]));
    const shown = order.rows.length, count = data.agreement.length, all = `${count} ${count === 1 ? 'case' : 'cases'}`;
    agreement.count.textContent = shown === count ? all : `${shown} of ${all}`;
    agreement.heads.forEach((th, i) => th.setAttribute('aria-sort', i !== order.column ? 'none' : order.down ? 'descending' : 'ascending'));
}
// label: of the button that shows all rows again; reset: what else it does.
function agreementFilters(label = 'all, worst first', reset = () => {}) {
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
        reset();
        arrange();
    }}, label);
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

// The inspector's texts for a case of the table.
const looked = {
    figure: 'The two images',
    // All pictures of the scene and level, by their captions; equal captions get the names as well.
    pictures: row => {
        const same = data.agreement.filter(r => r.scene === row.scene && r.level === row.level && r.image_a && r.image_b), size = name => `${data.images[name].width} ${data.images[name].height}`;
        const found = [...new Set([row.image_a, row.image_b, ...same.flatMap(r => [r.image_a, r.image_b])])].filter(name => size(name) === size(row.image_a));
        const caption = name => data.images[name].caption || name, twice = name => found.filter(other => caption(other) === caption(name)).length > 1;
        return found.map(name => [name, twice(name) ? `${caption(name)} (${name})` : caption(name)]);
    },
    name: row => `${row.verdict}: ${title(row)}`,
    listed: () => order.rows,
    mark: at => agreement.rows.forEach((tr, i) => { tr.classList.toggle('chosen', i === at); i === at ? tr.setAttribute('aria-current', 'true') : tr.removeAttribute('aria-current'); }),
    // Shows all differences if all are within the limits, otherwise those beyond the limit.
    threshold: row => row.verdict !== 'differ' ? 1e-9 : row.limits.max_abs ?? row.limits.p99_abs ?? row.limits.rmse ?? 1e-5,
    text: row => [el('p', {}, el('span', {class: style(row.verdict)}, row.verdict), row.tier ? `, tier ${row.tier}` : '', row.why ? `: ${row.why}` : '', '. ',
        `Worst pixel: column ${row.worst_pixel[0]}, row ${row.worst_pixel[1]}.`), ...askedTable(row), ...signalText(row), ...statisticsText(row), command(row.command) || '', ...viewerLink(row)],
};
// A link to the viewer with this row's settings, if the report has such a page.
function viewerLink(row) {
    const page = (data.viewers || {})[row.scene], words = row.variant || '';
    if (!page) return [];
    const at = `#level=${row.level}${words.includes('adapted TF') ? '&adapted' : ''}${words.startsWith('on-the-fly') ? '&code=none' : ''}`;
    return [el('p', {}, el('a', {href: page + at}, 'open in the viewer'))];
}

// Largest changes between two versions of a program; a name flips between their pictures.
function versions() {
    const rows = data.agreement.map((row, at) => ({row, at})).filter(c => c.row.comparison === 'versions' && c.row.statistics);
    if (rows.length === 0) return;
    $('versions').hidden = false;
    const flip = at => { view.mode = 'flip'; inspect(at, true); };
    $('versions').append(table('Versions.', [['verdict'], ['level', 1], ['scene'], ['versions'], ['largest change', 1], ['at'], ['scatter there', 1], ['pixels beyond chance', 1], ['RMSE', 1], ['of at most', 1]],
        rows.map(({row, at}) => el('tr', {'data-versions': row.number}, cell(row.verdict, false, style(row.verdict)), cell(String(row.level), true), cell(row.scene),
            cell(row.image_a && row.image_b ? el('button', {type: 'button', class: 'open', onclick: () => flip(at)}, `${row.a} and ${row.renderer}`) : `${row.a} and ${row.renderer}`),
            cell(number(row.statistics.largest_change), true), cell(`column ${row.statistics.pixel[0]}, row ${row.statistics.pixel[1]}, ${row.statistics.channel}`),
            cell(number(row.statistics.noise_there, 2), true), cell(`${row.statistics.pixels_beyond_chance} of ${row.statistics.pixels_tested}`, true), cell(brief(row.rmse), true), cell(brief(row.limits.rmse), true)))));
}

// ---- panels of failed cases ---------------------------------------------------
function still(uri, name, note) {
    return el('div', {class: 'panel'}, el('img', {src: uri, alt: name}), el('span', {}, el('strong', {}, name), note ? ` ${note}` : ''));
}
async function differencePanel(key, pictures) {
    const holder = el('div', {class: 'panel'});
    const d = await differences(key, pictures), {canvas} = paintDifference(d, null, -Infinity);
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', 'difference');
    canvas.style.cursor = 'default';
    holder.append(canvas, el('span', {}, el('strong', {}, 'difference'), ' log scale, 10⁻⁸ to 1'));
    return holder;
}
// The known mistake of a renderer, in the check that differs most.
function namedMistake(name) {
    const text = (data.mistakes || {})[name];
    if (!text) return [];
    const image = part => `mistake-${name}-${part}`;
    const picture = (part, ...label) => still(inlined.images[image(part)], ...label);
    const panels = el('div', {class: 'panels mistake'},
        picture('wanted', 'wanted', data.images[image('wanted')].caption), picture('got', name));
    differencePanel(name, inlined.mistakes)
        .then(d => panels.append(d, picture('explained', 'the reference', 'with the mistake')));
    return [el('p', {}, el('b', {}, 'It draws '), text, '.'), panels];
}
// The failed checks of one renderer, the farthest beyond its limit first.
function failedCalibration(name, unfit) {
    const all = data.calibration.filter(r => r.renderer === name);
    const beyond = r => r.value === null ? Infinity : r.value / r.limit;
    const failed = unfit.filter(r => r.renderer === name).sort((a, b) => beyond(b) - beyond(a));
    const measured = r => r.value === null ? ['nothing could be measured. ']
        : [number(r.value), ` ${r.unit || ''}, at most `, number(r.limit), '. '];
    const heading = `${name} failed ${failed.length} of ${all.length} checks of its calibration`;
    return el('div', {class: 'failure'}, el('h3', {}, heading), ...namedMistake(name), el('ul', {}, failed.map(r =>
            el('li', {}, el('strong', {}, r.check), ': ', measured(r), r.detail || ''))));
}
function failures() {
    const bad = data.agreement.filter(row => row.verdict === 'differ'), shown = 8, reasons = new Map();
    for (const row of data.agreement.filter(r => r.verdict === 'refused')) reasons.set(row.why, [...reasons.get(row.why) || [], row]);
    const unfit = data.calibration.filter(r => r.verdict === 'fail' && !(r.value === null && reasons.has(r.detail))); // a missing renderer is listed once
    if (bad.length + reasons.size + unfit.length === 0) return;
    $('failed').hidden = false;
    for (const row of bad.slice(0, shown)) {
        const panels = el('div', {class: 'panels'});
        if (row.image_a) panels.append(still(inlined.images[row.image_a], row.a, 'a'));
        if (row.image_b) panels.append(still(inlined.images[row.image_b], nameOf(row), 'b'));
        if (inlined.differences[row.number]) differencePanel(row.number).then(p => panels.append(p));
        $('failed').append(el('div', {class: 'failure'}, el('h3', {}, title(row)), el('p', {}, explain(row)), panels, command(row.command) || '',
            inlined.differences[row.number] ? el('button', {type: 'button', onclick: () => inspect(data.agreement.indexOf(row), true)}, 'inspect') : null));
    }
    if (bad.length > shown) $('failed').append(el('p', {}, `${bad.length - shown} more cases differ; see the table below.`));
    for (const name of new Set(unfit.map(r => r.renderer))) $('failed').append(failedCalibration(name, unfit));
    for (const [why, rows] of reasons)
        $('failed').append(el('div', {class: 'failure'}, el('h3', {}, `${rows.length} case${rows.length === 1 ? '' : 's'} refused: ${[...new Set(rows.map(renderer))].join(', ')}`), el('p', {}, why),
            el('details', {}, el('summary', {}, 'which'), el('ul', {}, rows.map(row => el('li', {}, title(row)))))));
}

// Cases that were not compared, by reason, stages first, each with the row's own reason.
const reasons = {
    signal: 'show too little for their limits',
    trait: 'need a feature that the renderer lacks',
    stage: 'did not run',
    budget: 'left out by the budget'
};
function notCompared() {
    const groups = new Map(), noun = row => row.comparison === 'stage' ? 'stage' : 'case';
    const all = data.agreement.filter(uncompared).sort((a, b) => (noun(b) === 'stage') - (noun(a) === 'stage'));
    for (const row of all) {
        const key = `${noun(row)} ${row.not_compared}`;
        groups.set(key, [...groups.get(key) || [], row]);
    }
    $('uncompared').hidden = groups.size === 0;
    for (const rows of groups.values()) {
        const of = noun(rows[0]), reason = reasons[rows[0].not_compared] || rows[0].not_compared;
        const summary = `${rows.length} ${of}${rows.length === 1 ? '' : 's'}: ${reason}`;
        $('uncompared').append(el('details', {open: of === 'stage' || rows.length <= 8}, el('summary', {}, summary),
            el('ul', {}, rows.map(row => el('li', {}, `${title(row)}: ${row.why}.`)))));
    }
}
