// SPDX-License-Identifier: MIT
// The page of certificates: an overview, cards that readers sort and filter, and the inspector.
const marks = {agree: '✓', differ: '✗', refused: '⊘', 'not compared': '–'};
const wordOf = row => row.missing ? 'not available' : row.verdict;
const markOf = row => row.missing ? '–' : marks[row.verdict];
const styleOf = row => row.missing ? 'not-compared' : style(row.verdict);
const sameScene = (a, b) => a.scene === b.scene && a.volume === b.volume;
const scenes = data.agreement.filter((row, i) => data.agreement.findIndex(r => sameScene(r, row)) === i);
// Scenes of one name are told apart by their volumes.
const isAlone = row => scenes.filter(s => s.scene === row.scene).length === 1;
const sceneName = row => isAlone(row) ? row.scene : `${row.scene}, ${row.volume || 'suite'}`;
const cardId = row => `${row.renderer}:${sceneName(row).replaceAll(' ', '-')}`;
const utc = made => made.replace('T', ' ').replace('Z', ' UTC');

function head() {
    const good = data.verdict === 'agree';
    $('verdict').classList.add(good ? 'good' : 'bad');
    $('verdict').prepend(good ? '✓ ' : '✗ ');
    if (data.command) $('again').append(command(data.command));
}

function overview() {
    const link = row => cell(el('a', {href: `#${encodeURIComponent(cardId(row))}`, title: row.sentence},
        `${markOf(row)} `, wordOf(row)), false, styleOf(row));
    const of = (r, s) => data.agreement.find(row => row.renderer === r.renderer && sameScene(row, s));
    const badge = r => el('img', {src: inlined.images[r.badge], alt: `isoshade: ${r.words}`, title: r.badge});
    const lines = data.renderers.map(r => el('tr', {id: r.renderer},
        el('th', {scope: 'row'}, r.title, el('small', {}, r.version)), cell(badge(r)),
        scenes.map(s => of(r, s) ? link(of(r, s)) : cell(''))));
    $('overview').append(table('A row for each renderer, with its badge. A cell leads to the certificate.',
        [['renderer'], ['badge'], ...scenes.map(s => [sceneName(s)])], lines));
}

// The worst row of each kind of comparison, with its limits.
function comparisons(row) {
    const limit = (c, key) => (c.limits || {})[key] === undefined ? ''
        : el('small', {}, 'of ', number(c.limits[key], 2));
    const value = (c, key) => cell([number(c[key], 2), limit(c, key)], true, `two-lines ${style(c.verdict)}`);
    const measured = row.comparisons.filter(c => c.rmse !== null && c.rmse !== undefined);
    const lines = measured.map(c => el('tr', {}, cell([c.words || c.comparison, el('small', {}, ` × ${c.rows}`)]),
        value(c, 'rmse'), value(c, 'max_abs')));
    const head = (name, i) => el('th', {scope: 'col', class: i ? 'n' : null}, name);
    const heads = el('thead', {}, el('tr', {}, ['worst of each kind', 'RMSE', 'max'].map(head)));
    return lines.length === 0 ? '' : scroller('worst of each kind', el('table', {}, heads, el('tbody', {}, lines)));
}

function failedCheck(c) {
    const value = c.value === null ? [': nothing could be measured']
        : [': ', number(c.value), ` ${c.unit || ''}, at most `, number(c.limit)];
    return el('li', {}, el('strong', {}, c.check), value, c.detail ? `. ${c.detail}` : '');
}

function details(row) {
    const list = (name, texts) => (texts || []).length === 0 ? ''
        : el('p', {}, el('b', {}, `${name}: `), texts.join(', '), '.');
    const reasons = row.verdict === 'refused' ? [] : [row.why].filter(Boolean);
    return el('details', {}, el('summary', {}, 'limits, features, versions'),
        row.failed.length ? el('ul', {}, row.failed.map(failedCheck)) : '', list('Limits', reasons),
        list('What differs by design', [row.limits_why].filter(why => why && why !== row.why)),
        list('Draws', row.draws), list('Lacks', row.lacks), ...signalText(row), ...askedTable(row),
        el('p', {class: 'about'}, `${row.version || 'unknown version'}; isoshade ${row.isoshade}; `,
            `report ${row.report}, ${utc(row.made)}.`),
        list('Older reports', row.superseded.map(s => `${s.report} of ${s.made.slice(0, 10)}`)));
}

// Pictures of differences are painted when they come into view.
const painter = new IntersectionObserver(entries => {
    for (const {target} of entries.filter(e => e.isIntersecting)) {
        painter.unobserve(target);
        differencePanel(data.agreement[Number(target.dataset.at)].number).then(panel => target.replaceWith(panel));
    }
}, {rootMargin: '400px'});

function pictures(row, at) {
    const panels = el('div', {class: 'panels'}), uri = inlined.images[row.image_b];
    if (uri) panels.append(still(uri, row.title, `level ${row.level}`));
    if (inlined.differences[row.number]) {
        const place = el('div', {class: 'panel', 'data-at': at}, el('canvas', {width: 1, height: 1}));
        panels.append(place);
        painter.observe(place);
    }
    return panels.childElementCount ? panels : '';
}

// The known mistake of a renderer, in the calibration that differs most.
function mistake(row) {
    const panels = ['wanted', 'got'].map(part => [part, inlined.images[row[`mistake_${part}`]]]).filter(([, uri]) => uri)
        .map(([part, uri]) => still(uri, part, 'calibration'));
    return [el('p', {}, el('b', {}, 'It draws '), row.mistake, '.'),
        panels.length ? el('div', {class: 'panels mistake'}, ...panels) : ''];
}

function card(row, at) {
    const compared = Boolean(inlined.differences[row.number]);
    const verdict = el('span', {class: styleOf(row)}, `${markOf(row)} ${wordOf(row)}`);
    return el('article', {class: `card ${style(row.verdict)}`, id: cardId(row)},
        el('h3', {}, row.title), el('p', {class: 'about'}, sceneName(row)), pictures(row, at),
        el('p', {}, verdict, '. ', row.sentence),
        ...(row.mistake ? mistake(row) : []), comparisons(row), details(row),
        row.command ? el('details', {}, el('summary', {}, 'repeat it'), command(row.command)) : '',
        compared ? el('button', {type: 'button', onclick: () => inspect(at, true)}, 'inspect') : '');
}

function cards() {
    agreement = {rows: data.agreement.map(card), body: el('div', {class: 'cards'}), heads: [],
        count: el('output', {class: 'count'})};
    const sort = el('select', {'data-sort': '', onchange: () => {
        order.column = columns.findIndex(([name]) => name === sort.value);
        order.down = sort.value !== 'scene';
        arrange();
    }}, ['', 'verdict', 'scene', 'RMSE', 'max'].map(name => el('option', {value: name}, name || 'scene by scene')));
    const controls = agreementFilters('all', () => { sort.value = ''; });
    controls.insertBefore(el('label', {}, 'sort by', sort), controls.children[1]);
    $('cards').append(controls, agreement.body);
    arrange();
}

head();
overview();
cards();
const pictured = data.agreement.map((row, at) => ({row, at})).filter(c => inlined.differences[c.row.number]);
if (pictured.length > 0) {
    buildInspector(pictured, {...looked, figure: 'The two pictures of a certificate', pictures: null,
        name: row => `${row.verdict}: ${row.title}, ${sceneName(row)}`});
    if (!followHash()) inspect(pictured[0].at, null);
}
// The cards were not there yet when the browser looked for the address's part.
if (location.hash) document.getElementById(decodeURIComponent(location.hash.slice(1)))?.scrollIntoView();
document.documentElement.dataset.ready = 'yes';
