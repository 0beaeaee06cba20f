// SPDX-License-Identifier: MIT
// Fills the page, in the order that its reader sees.
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
