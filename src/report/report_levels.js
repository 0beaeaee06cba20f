// SPDX-License-Identifier: MIT
// Levels against level 0; calibrations; versions, machine and options of the report.
const wayOf = r => `${r.method === 'on-the-fly' ? 'gradients on the fly' : r.method}, ${r.tf === 'scaled' ? 'extinction scale' : `${r.tf} TF`}`;
// The default minus another way, with half of the interval, and the verdict: better, worse or within the scatter.
function against(row, way, key) {
    const f = way.figures.find(x => x.figure === key), margin = Math.max(row.margin, f.half_width ?? Infinity);
    const word = f.better ? 'worse' : -f.difference > margin ? 'better' : 'within the scatter';
    const plusMinus = f.half_width === null ? ', one view' : ` ± ${plain(f.half_width)}`;
    return {text: `${f.difference < 0 ? '−' : '+'}${plain(Math.abs(f.difference))}${plusMinus}`, word, f};
}
function levelVerdicts() {
    const rows = data.levels || [];
    $('levels-verdict').hidden = !data.levels_sentence;
    $('levels-verdict').textContent = data.levels_sentence; // the reason if none was judged
    if (rows.length === 0) return;
    const good = rows.every(r => r.verdict === 'agree');
    $('levels').hidden = false;
    $('levels-verdict').textContent = `${good ? '✓' : '✗'} ${data.levels_sentence}`;
    $('levels-verdict').classList.add(good ? 'good' : 'bad');
    const lines = [];
    for (const row of rows) row.figures.forEach((f, i) => {
        const simple = against(row, row.simple, f.figure);
        // The other method that is nearest to level 0 by this figure.
        const best = [...row.rivals].sort((a, b) => a.figures[i].value - b.figures[i].value)[0];
        const rival = best ? against(row, best, f.figure) : null;
        lines.push(el('tr', {'data-level': row.level, 'data-verdict': row.verdict}, cell(i ? '' : String(row.level), true), cell(i ? '' : row.verdict, false, i ? '' : row.verdict),
            cell(i ? '' : wayOf(row)), cell(f.name), cell(number(f.value), true, f.held ? '' : 'differ'), cell(f.asked === null ? 'no limit' : number(f.asked), true),
            cell(`${simple.text}, ${simple.word}`, true, simple.word === 'worse' ? 'differ' : ''),
            cell(rival ? `${wayOf(best)}: ${rival.text}, ${rival.word}` : '–', false, rival && rival.word === 'worse' ? 'named' : '')));
    });
    $('levels').append(table(`Levels. Differences are the default's figure minus the other's, means over ${[...new Set(rows.map(r => r.views))].join(' or ')} views with half of the ${plain(100 * rows[0].confidence)} % interval; ` +
        `below a margin of ${plain(rows[0].margin)} they are invisible.${rows[0].views < 6 ? ' Few views have wide intervals.' : ''}`,
        [['level', 1], ['verdict'], ['default'], ['figure'], ['value', 1], ['at most', 1], ['to the simple way', 1], ['to the nearest of the others']], lines));
    const options = rows.flatMap(r => r.rivals.filter(x => x.better).map(x => el('li', {}, `Level ${r.level}: ${wayOf(x)}, by ${x.figures.filter(f => f.better).map(f => `${f.name} (${plain(f.value)} against ${plain(f.value + f.difference)})`).join(' and ')}: `, el('code', {}, x.option))));
    if (options.length) $('levels').append(el('p', {}, 'Better than the default in a figure, beyond the scatter, and worse in none:'), el('ul', {class: 'rivals'}, options));
    const bounded = rows.filter(r => r.bound);
    if (bounded.length) $('levels').append(el('p', {class: 'bounds'}, 'RMSE, and its bound, which is computed before drawing: ' +
        bounded.map(r => `level ${r.level} ${plain(r.bound.rmse)} of at most ${plain(r.bound.bound)}${r.bound.held ? '' : ` (above it by ${plain(r.bound.above)} in a view: one of the two is wrong)`}`).join(', ') +
        `. Means over the first ${bounded[0].bound.views === 1 ? 'view' : `${bounded[0].bound.views} views`}.`));
    const scaled = rows.filter(r => r.extinction_scale);
    if (scaled.length) $('levels').append(el('p', {class: 'scaled'}, 'Shown with extinction scales: ' + scaled.map(r => `level ${r.level} ${!r.extinction_scale.has_effect ? 'changes no picture, so it is not used' :
        r.extinction_scale.held ? `equals one made of level 0, other than 1 at ${r.extinction_scale.scaled_voxels} voxels` : `differs from one made of level 0, at ${r.extinction_scale.differing_voxels} voxels`}`).join(', ') + '.'));
    const wrong = rows.filter(r => !r.stored.held);
    $('levels').append(el('p', {}, wrong.length === 0 ? 'Every stored level equals one made of level 0.' :
        wrong.map(r => `Level ${r.level} differs from one made of level 0: values by up to ${plain(r.stored.scalar)} of their range, directions by ${plain(r.stored.direction_deg)} degrees on average. `)));
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
    const tf = r => ['adapted', 'scaled'].includes(r.tf) ? r.tf : 'original', adapted = data.consistency.some(r => tf(r) !== 'original');
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
    // One row per level and TF, one column per method.
    const methods = [...new Set(pictured.map(r => r.method))], reference = pictured[0].reference_image;
    const panels = el('div', {class: 'levels', style: `grid-template-columns: repeat(${methods.length + 1}, minmax(0, 190px))`});
    let first = true;
    for (const k of shown) for (const which of ['original', 'adapted', 'scaled']) {
        const of = method => pictured.find(r => r.level === k && r.method === method && tf(r) === which);
        if (methods.every(m => !of(m) || of(m).original_kept)) continue; // equal to the row above
        panels.append(first && reference ? still(inlined.images[reference], 'level 0') : el('div', {}));
        first = false;
        for (const method of methods) {
            const r = of(method);
            panels.append(r ? still(inlined.images[r.image], `level ${k}, ${method}`, `${which === 'scaled' ? 'extinction scale, ' : which === 'adapted' ? (r.original_kept ? 'original TF kept, ' : 'adapted TF, ') : ''}1 − SSIM ${plain(r.ssim_dissimilarity_mean)}`) : el('div', {}));
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
// Starts of external programs. Their output is untrusted, and added as text.
function programs() {
    const entries = Object.entries(data.programs || {});
    if (entries.length === 0) return;
    const ended = p => p.timed_out ? 'at its time limit' : p.signal ? `by signal ${p.signal}` : p.exit_code === null ? '' : `exit code ${p.exit_code}`;
    const rows = entries.map(([name, p]) => el('tr', {}, cell(name), cell(p.command.join(' ')), cell(p.tier), cell(p.limits ? p.limits.why : ''), cell(String(p.starts), true), cell(number(p.seconds), true),
        cell(ended(p), false, p.failure ? 'fail' : ''), cell(p.failure || ''), cell(p.output.flatMap((line, i) => i ? [el('br'), line] : [line]))));
    $('calibration').append(table('How programs were run: the first start that failed, or else the last one.', [['renderer'], ['command'], ['tier'], ['cause of its limits'], ['starts', 1], ['seconds', 1], ['ended'], ['failure'], ['last output']], rows));
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
