// SPDX-License-Identifier: MIT
// Shared by all pages: data, builders of elements, numbers.
const data = JSON.parse(document.getElementById('data').textContent);
const inlined = JSON.parse(document.getElementById('inlined').textContent);
if (data.certificates) data.agreement = data.certificates; // a row for each
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

const cell = (content, numeric, extra) => el('td', {class: [numeric ? 'n' : '', extra || ''].join(' ').trim() || null}, content);
// A wide part scrolls by itself, with keys, too.
const scroller = (name, ...parts) => el('div', {class: 'scroll', tabindex: 0, role: 'group', 'aria-label': name}, ...parts);
function table(text, heads, rows) {
    return scroller(text, el('table', {}, caption(text),
        el('thead', {}, el('tr', {}, heads.map(([name, numeric]) => el('th', {class: numeric ? 'n' : null, scope: 'col'}, name)))),
        el('tbody', {}, rows)));
}
// 3.2 x 10^-6, or a plain number if that is short. null: a dash.
function number(x, digits = 3) {
    if (x === null || x === undefined) return '–';
    if (x === 0) return '0';
    const magnitude = Math.abs(x);
    if (magnitude >= 0.001 && magnitude < 10000) return String(Number(x.toPrecision(digits)));
    const [mantissa, exponent] = x.toExponential(digits - 1).split('e');
    return el('span', {class: 'power'}, `${Number(mantissa)}\u2009×\u200910`, el('sup', {}, String(Number(exponent)).replace('-', '−')));
}
// For tables: two digits, so that exponents are aligned.
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
// Name of a row on this page; row.b is its name in report.json, the only one on a page of two reports.
const nameOf = row => inlined.words ? inlined.words[row.number] : row.b;
const title = row => row.comparison === 'stage' ? `${row.scene}: the stage ${row.variant}` : `${row.scene}, ${level(row)}: ${row.a} against ${nameOf(row)}`;
const uncompared = row => row.verdict === 'not compared', style = verdict => verdict.replaceAll(' ', '-');
const ratio = (row, digits) => row.severity === null ? '∞' : row.severity < 0.01 ? '< 0.01' : row.severity < 1e4 ? String(Number(row.severity.toPrecision(digits))) : row.severity.toExponential(0);
const names = {rmse: 'RMSE', max_abs: 'max', p99_abs: 'p99', ssim_dissimilarity: '1 − SSIM', flip_mean: 'FLIP'};
