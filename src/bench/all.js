// SPDX-License-Identifier: MIT
// Draws the table of the page that bench all writes.
const data = JSON.parse(document.getElementById('data').textContent);

function put(parent, name, text, kind) {
    const element = document.createElement(name);
    if (text !== undefined)
        element.textContent = text;
    if (kind)
        element.className = kind;
    parent.append(element);
    return element;
}

// Bytes as MB or GB, other units with four digits.
function show(value, unit) {
    if (value === null)
        return '–';
    if (unit === 'bytes')
        return value >= 1e9 ? `${(value / 1e9).toPrecision(3)} GB` : `${(value / 1e6).toPrecision(3)} MB`;
    return String(Number(value.toPrecision(4)));
}

// Bars hold for full sizes only.
const hasBar = row => row.bar !== null && !data.options.quick;

const WIDTH = 180, FACTOR = 4;

function drawRuns(cell, row) {
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    const place = value => WIDTH / 2 * (1 + Math.log(value / row.median) / Math.log(FACTOR));
    const add = (name, attributes) => {
        const element = document.createElementNS('http://www.w3.org/2000/svg', name);
        for (const [key, value] of Object.entries(attributes))
            element.setAttribute(key, value);
        svg.append(element);
    };
    svg.setAttribute('viewBox', `0 0 ${WIDTH} 16`);
    svg.setAttribute('role', 'img');
    svg.setAttribute('aria-label', `runs: ${row.values.map(v => show(v, row.unit)).join(', ')}`);
    add('line', {class: 'axis', x1: 0, x2: WIDTH, y1: 8, y2: 8});
    if (hasBar(row) && Math.abs(Math.log(row.bar / row.median)) <= Math.log(FACTOR))
        add('line', {class: 'bar', x1: place(row.bar), x2: place(row.bar), y1: 1, y2: 15});
    for (const value of row.values)
        add('circle', {class: 'run', cx: Math.min(Math.max(place(value), 3), WIDTH - 3), cy: 8, r: 3, 'fill-opacity': .6});
    cell.append(svg);
}

for (const row of data.headlines) {
    const line = put(document.getElementById('rows'), 'tr');
    put(line, 'td', row.name);
    put(line, 'td', row.cause ? `${row.sentence} (${row.cause})` : row.sentence);
    put(line, 'td', show(row.median, row.unit), 'n');
    put(line, 'td', row.unit === 'bytes' ? '' : row.unit);
    put(line, 'td', row.peer || '');
    put(line, 'td', !hasBar(row) ? '' : `${row.lower_is_better ? '≤' : '≥'} ${show(row.bar, row.unit)}`, 'n');
    put(line, 'td', row.met === null ? '' : row.met ? 'met' : 'missed', row.met === false ? 'fail' : 'pass');
    const runs = put(line, 'td');
    if (row.median !== null && row.median > 0)
        drawRuns(runs, row);
}
const machine = data.machine;
document.getElementById('machine').textContent =
    `${machine.processor}, ${machine.cores} cores, ${(machine.memory_bytes / 2 ** 30).toFixed(1)} GiB of memory; ${machine.system}`;
document.getElementById('again').textContent = data.command;
const commands = document.getElementById('commands');
for (const row of data.headlines) {
    put(commands, 'dt', row.name);
    put(put(commands, 'dd'), 'code', `isoshade ${row.command}`);
}
