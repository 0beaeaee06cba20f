// SPDX-License-Identifier: MIT
// Fills the page from top to bottom.
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
    for (const [name, why] of Object.entries(data.left_out || {})) $('about').after(el('p', {class: 'about'}, `Left out: ${name}: ${why}`));
    if (data.command) $('again').append(command(data.command), el('p', {class: 'about'}, 'Run the commands of this page in the folder of this command. Without --full-paths they name files of absolute paths by their last names.'));
}

// ---- sections -------------------------------------------------------------------
failures();
notCompared();
versions();
function agreements() {
    if (data.charts_missing) $('agreement').append(el('p', {class: 'refused'}, `No charts: ${data.charts_missing}`));
    $('agreement').append(...agreementTable());
    const pictured = data.agreement.map((row, at) => ({row, at})).filter(c => c.row.image_a && c.row.image_b);
    if (pictured.length > 0) {
        buildInspector(pictured, looked);
        const rank = ({row}) => row.verdict === 'refused' ? -2 : severityOf(row);
        const worst = pictured.reduce((a, b) => rank(b) > rank(a) ? b : a);
        if (!followHash()) inspect(worst.at, null);
    }
    if (inlined.charts.agreement) $('chart').append(el('figure', {}, el('img', {src: inlined.charts.agreement, alt: 'RMSE of each comparison with its limit'}),
        figcaption('RMSE of each comparison on a log axis, the 40 worst at most. Data and script: charts/agreement.csv, charts/agreement.gp; charts/style.gp restyles all charts.')));
}
// Each section of report.json (src/report/sections.h), in the page's order.
const shows = {agreement: agreements, levels: levelVerdicts, consistency: consistency, calibration: calibration};
for (const show of Object.values(shows)) show();
programs();
colophon();
document.documentElement.dataset.ready = 'yes';
