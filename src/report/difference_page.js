// SPDX-License-Identifier: MIT
// The page of two reports: changed rows, facts and pictures, and the inspector of pictures.
const shown = value => value === null ? '–' : typeof value === 'number' ? number(value, 4) : typeof value === 'object' ? (Array.isArray(value) ? value.join(' × ') : JSON.stringify(value)) : typeof value === 'boolean' ? (value ? 'yes' : 'no') : value;
const tolerance = w => w.tolerance === null ? '' : [number(w.tolerance, 2), el('small', {}, ` ${w.why}`)];
const verdictCell = verdict => cell(verdict === null ? '–' : verdict, false, verdict === null ? '' : style(verdict));
const metricName = what => what.replace(/^limit of (.*)$/, (all, metric) => `limit of ${names[metric] || metric}`);

function head() {
    const good = data.verdict === 'agree';
    $('verdict').classList.add(good ? 'good' : 'bad');
    $('verdict').prepend(good ? '✓ ' : '✗ ');
    const line = (name, about) => el('tr', {}, cell(name), cell(about.path), cell((about.made || '').replace('T', ' ').replace('Z', ' UTC')), verdictCell(about.verdict), cell([about.sentence || '', about.levels_sentence ? ` ${about.levels_sentence}` : '']));
    $('reports').append(table('The two reports.', [[''], ['report'], ['made'], ['verdict'], ['']], [line('A', data.a), line('B', data.b)]));
    if (data.command) $('again').append(command(data.command));
}

// One line per change; the first one has the row's name.
function rows() {
    if (data.rows.length === 0) return;
    $('rows').hidden = false;
    const lines = [];
    for (const row of data.rows) {
        const at = data.pictures.findIndex(p => p.name === row.picture && p.number !== undefined);
        const name = at < 0 ? row.name : el('button', {type: 'button', class: 'open', onclick: () => inspect(at, true)}, row.name);
        const what = row.what.filter(w => w.what !== 'verdict'), first = [cell(row.change), cell(name), verdictCell(row.verdict_a), verdictCell(row.verdict_b)];
        const rest = w => w ? [cell(names[w.what] || metricName(w.what), false, 'power'), cell(shown(w.a), true), cell(shown(w.b), true), cell(tolerance(w))] : [cell(''), cell('–', true), cell('–', true), cell('')];
        (what.length ? what : [null]).forEach((w, i) => lines.push(el('tr', {'data-change': i ? null : row.change}, i ? [cell(''), cell(''), cell(''), cell('')] : first, rest(w))));
    }
    $('rows').append(table(`${data.rows.length} of ${data.row_count} rows. A name opens its two pictures if they differ.`,
        [['change'], ['row'], ['A'], ['B'], ['what'], ['in A', 1], ['in B', 1], ['tolerance']], lines));
}

function facts() {
    if (data.facts.length === 0) return;
    $('facts').hidden = false;
    $('facts').append(table('Versions and options of the reports, which may explain changes.', [['what'], ['in A'], ['in B'], ['']],
        data.facts.map(f => el('tr', {}, cell(f.fact.replaceAll('_', ' ')), cell(shown(f.a)), cell(shown(f.b)), cell(f.counts ? '' : el('small', {}, 'not counted'))))));
}

// The table of pictures, whose rows open the inspector.
let pictureRows = [];
function pictures() {
    const section = $('pictures');
    if (data.pictures_missing) section.append(el('p', {class: 'refused'}, data.pictures_missing));
    if (data.pictures.length === 0) {
        section.append(el('p', {}, data.picture_count ? `All ${data.picture_count} pictures are the same in every bit.` : 'No picture was compared.'));
        return;
    }
    pictureRows = data.pictures.map((p, at) => {
        const open = p.number === undefined ? p.name : el('button', {type: 'button', class: 'open', onclick: e => { e.stopPropagation(); inspect(at, true); }}, p.name);
        return el('tr', {class: p.number === undefined ? null : 'pick', onclick: () => { if (!String(getSelection())) inspect(at, true); }}, cell(p.counts ? 'differs' : 'within its tolerance', false, p.counts ? 'differ' : 'reported'),
            cell([open, p.caption ? el('small', {}, ` ${p.caption}`) : '']), p.problem ? el('td', {colspan: 5}, p.problem) : [cell(brief(p.rmse), true), cell([brief(p.tolerance), el('small', {}, ` ${p.why}`)], true), cell(brief(p.max_abs), true), cell(brief(p.flip_mean), true), cell(`column ${p.worst_pixel[0]}, row ${p.worst_pixel[1]}`)]);
    });
    section.append(table(`${data.pictures.length} of ${data.picture_count} pictures; the largest differences come first.`,
        [[''], ['picture'], ['RMSE', 1], ['tolerance', 1], ['max', 1], ['FLIP', 1], ['worst pixel']], pictureRows));
}

head();
rows();
facts();
pictures();
const flipped = data.pictures.map((p, at) => ({at, row: {...p, a: `A: ${p.name}`, b: `B: ${p.name}`, image_a: `a/${p.name}`, image_b: `b/${p.name}`}})).filter(c => c.row.number !== undefined);
if (flipped.length > 0) {
    view.mode = 'flip';
    buildInspector(flipped, {
        figure: 'One picture in report A and in report B',
        name: row => `${row.counts ? 'differs' : 'within its tolerance'}: ${row.name}`,
        listed: () => data.pictures.map((p, at) => at),
        mark: at => pictureRows.forEach((tr, i) => { tr.classList.toggle('chosen', i === at); i === at ? tr.setAttribute('aria-current', 'true') : tr.removeAttribute('aria-current'); }),
        threshold: () => 1e-9,
        text: row => [el('p', {}, `RMSE `, number(row.rmse), ', tolerance ', number(row.tolerance), ` (${row.why}). Largest difference `, number(row.max_abs), `, at column ${row.worst_pixel[0]}, row ${row.worst_pixel[1]}.`),
            ...data.rows.filter(r => r.picture === row.name).flatMap(r => [r.command_a ? command(r.command_a) : '', r.command_b && r.command_b !== r.command_a ? command(r.command_b) : ''])],
    });
    if (!followHash()) inspect(flipped[0].at, null);
}
document.documentElement.dataset.ready = 'yes';
