// SPDX-License-Identifier: MIT
// Uses the report as its reader does, and writes a line a finding into the page, for tests/check_report_page.sh to read.
(async () => {
    const lines = [], say = (name, value) => lines.push(`${name} ${value}`);
    const $ = selector => document.querySelector(selector);
    const settle = () => new Promise(done => setTimeout(done, 150));
    const data = JSON.parse($('#data').textContent);
    const canvases = () => [...document.querySelectorAll('#inspector canvas[tabindex]')];
    const shown = () => canvases().filter(c => !c.parentElement.hidden);
    const pictures = () => canvases().map(c => c.toDataURL());
    const button = text => [...document.querySelectorAll('#inspector button')].find(b => b.textContent.startsWith(text));
    const button2 = text => [...document.querySelectorAll('#agreement button')].find(b => b.textContent === text);
    const above = () => Number(/(\d+) of/.exec($('#inspector canvas[aria-label=difference]').parentElement.textContent)[1]);
    const slide = async value => {
        const slider = $('#inspector input[type=range]');
        slider.value = value;
        slider.dispatchEvent(new Event('input'));
        await settle();
    };
    const press = async key => { document.activeElement.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true, cancelable: true})); await settle(); };
    const choose = async (control, value, event) => { control.value = value; control.dispatchEvent(new Event(event, {bubbles: true})); await settle(); };
    const listed = () => [...document.querySelectorAll('#agreement tbody tr')];
    const texts = column => listed().map(tr => tr.cells[column].textContent);
    // WCAG: relative luminance, and the ratio of two colors of the style sheet.
    const luminance = hex => [1, 3, 5].map(i => parseInt(hex.length > 4 ? hex.slice(i, i + 2) : hex[(i + 1) / 2].repeat(2), 16) / 255)
        .map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4).reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
    const contrast = (a, b) => { const [x, y] = [luminance(a), luminance(b)].sort((u, v) => v - u); return (x + 0.05) / (y + 0.05); };
    const leastContrast = rules => {
        const style = [...rules].find(r => r.selectorText === ':root').style, of = name => style.getPropertyValue(`--${name}`).trim();
        return Math.min(...['ink', 'quiet', 'text', 'good', 'bad', 'link'].flatMap(front => ['paper', 'soft', 'chosen'].map(back => contrast(of(front), of(back)))));
    };
    try {
        while (document.documentElement.dataset.ready !== 'yes') await settle();
        await settle();
        const levels = [...document.querySelectorAll('#consistency tbody tr')];
        const told = (tr, row) => tr.textContent.includes(row.method) && tr.dataset.tf === row.tf && tr.textContent.includes('original kept') === (row.original_kept !== null);
        const ordered = [...data.consistency].sort((x, y) => x.level - y.level);
        say('consistency_rows', levels.length === ordered.length && levels.every((tr, i) => told(tr, ordered[i])) && levels.length);
        say('rows_under_the_adapted_tf', levels.filter(tr => tr.dataset.tf === 'adapted').length);

        // A line a figure of each level, the first with the verdict; a figure beyond what was asked for is marked.
        const figures = (data.levels || []).flatMap(r => r.figures.map((f, i) => ({r, f, i}))), lines2 = [...document.querySelectorAll('#levels tbody tr')];
        say('levels_told', figures.length > 0 && lines2.length === figures.length && figures.every(({r, f, i}, at) => lines2[at].cells[3].textContent === f.name &&
            (i > 0 || lines2[at].cells[1].textContent === r.verdict) && lines2[at].cells[4].classList.contains('differ') === !f.held));
        say('uncompared', [...document.querySelectorAll('#uncompared details')].map(d => `${d.open ? 'open' : 'closed'} ${d.querySelector('summary').textContent}`).join('; '));
        say('levels_verdict', $('#levels-verdict').textContent);

        // Two versions: the table says the pixel, and a name flips between the two.
        const beside = $('#versions tbody tr');
        if (beside) {
            beside.querySelector('button').click();
            await settle();
            say('versions', !$('#versions').hidden && /column 3, row 4, G/.test(beside.textContent) && shown().length === 1 && location.hash === `#case-${beside.dataset.versions}`);
        }

        // A named mistake: wanted, got, their difference, and the reference with the mistake, which looks as got does.
        const explained = [...document.querySelectorAll('#failed .mistake')].filter(panels => {
            const pictures = [...panels.querySelectorAll('.panel > :first-child')];
            const [wanted, got, difference, known] = pictures.map(picture => {
                const canvas = document.createElement('canvas');
                canvas.width = canvas.height = 32;
                canvas.getContext('2d').drawImage(picture, 0, 0);
                return canvas.getContext('2d').getImageData(0, 0, 32, 32).data;
            });
            const apart = (x, y) => x.reduce((sum, value, i) => sum + Math.abs(value - y[i]), 0) / x.length;
            return apart(wanted, got) > 8 * apart(got, known) && difference.some((value, i) => i % 4 < 3 && value > 0);
        });
        say('mistakes_explained', explained.length);

        const failed = $('#failed'), rows = [...document.querySelectorAll('#agreement tbody tr')];
        say('failed_cases_shown', !failed.hidden && failed.querySelectorAll('.failure').length);
        say('failed_cases_on_top', Boolean(failed.compareDocumentPosition($('#agreement')) & Node.DOCUMENT_POSITION_FOLLOWING));
        say('rows', rows.length === data.agreement.length && rows.length);
        say('worst_row_first', rows[0].cells[0].textContent);
        say('reproduce', $('#failed .command code').textContent);
        say('panels_side_by_side', shown().length);

        await slide(-9);
        const all = above(), painted = pictures()[2];
        await slide(-5);
        const some = above();
        await slide(0);
        say('threshold', all > 0 && some <= all && above() === 0 && pictures()[2] !== painted);
        await slide(-9);

        const whole = pictures();
        canvases()[0].dispatchEvent(new WheelEvent('wheel', {deltaY: -400, clientX: 10, clientY: 10, cancelable: true}));
        await settle();
        const zoomed = pictures();
        say('zoom_in_step', zoomed.filter((p, i) => p !== whole[i]).length);
        button('whole').click();
        await settle();
        say('whole_again', pictures().every((p, i) => p === whole[i]));

        // What is under the pointer stays there.
        const canvas = canvases()[1], box = canvas.getBoundingClientRect(), at = {clientX: box.left + 0.7 * box.width, clientY: box.top + 0.4 * box.height, bubbles: true};
        const under = async () => {
            canvas.dispatchEvent(new PointerEvent('pointermove', at));
            await settle();
            return /column \d+, row \d+/.exec($('.readout').textContent)[0];
        };
        const before = await under();
        canvas.dispatchEvent(new WheelEvent('wheel', {deltaY: -500, cancelable: true, ...at}));
        say('zoom_keeps_the_pixel_under_the_pointer', await under() === before);
        const close = pictures()[0];
        await press('d');
        await press('s');
        say('zoom_outlives_the_mode', pictures()[0] === close);
        canvases()[0].focus();
        await press('0');
        say('keys_zoom', pictures()[0] === whole[0]);

        button('flip').click();
        await settle();
        const a = shown();
        button('swap').click();
        await settle();
        const b = shown();
        say('flip', a.length === 1 && b.length === 1 && a[0] !== b[0]);
        button('flip').focus();
        await press(' ');
        const c = shown();
        await press('f');
        say('keys_flip', c.length === 1 && c[0] === a[0] && shown()[0] === b[0]);
        button('side').click();

        const first = $('#inspector select').value;
        await press('n');
        say('next_case', $('#inspector select').value !== first && location.hash.startsWith('#case-') && $('tr.chosen').id === location.hash.replace('#case', 'row'));
        await press('p');

        const filter = name => $(`#agreement select[data-filter=${name}]`), search = $('#agreement input[type=search]');
        await choose(filter('renderer'), 'povray', 'change');
        const povray = data.agreement.filter(r => r.renderer === 'povray').length;
        say('filter', povray > 0 && listed().length === povray && texts(4).every(t => t.startsWith('povray')) && $('#agreement .count').textContent.startsWith(`${povray} of`));
        await choose(search, 'LIMIT povray', 'input');
        say('words', listed().length > 0 && texts(4).every(t => t.startsWith('povray, limit')));
        button2('all, worst first').click();
        await settle();
        say('all_again', listed().length === data.agreement.length);
        const heading = [...document.querySelectorAll('#agreement th')].find(th => th.textContent === 'RMSE');
        const sorted = down => { const list = listed().map(tr => data.agreement.find(r => `row-${r.number}` === tr.id).rmse ?? -1); return list.every((v, i) => i === 0 || (down ? list[i - 1] >= v : list[i - 1] <= v)); };
        heading.firstChild.click();
        const descending = sorted(true) && heading.getAttribute('aria-sort') === 'descending';
        heading.firstChild.click();
        say('sort', descending && sorted(false) && heading.getAttribute('aria-sort') === 'ascending');
        button2('all, worst first').click();

        let copied = '';
        Object.defineProperty(navigator, 'clipboard', {value: {writeText: async text => { copied = text; }}, configurable: true});
        $('#failed .command button').click();
        await settle();
        say('copy', copied === data.agreement[0].command && $('#failed .command button').textContent === 'copied');

        const nameless = [...document.querySelectorAll('button, select, input, canvas[tabindex], img')].filter(e => !(e.getAttribute('aria-label') || e.alt || e.textContent.trim() || e.closest('label')));
        say('controls_without_a_name', nameless.length);
        const rules = document.styleSheets[0].cssRules;
        say('contrast_light', leastContrast(rules) >= 4.5);
        say('contrast_dark', leastContrast([...rules].find(r => r.media && r.media.mediaText.includes('dark')).cssRules) >= 4.5);
        say('versions_and_machine', /Versions/.test($('#colophon').textContent) && /Machine/.test($('#colophon').textContent));
        // Any two pictures of the scene and level: one with itself has no difference, with another it has.
        const picks = side => $(`#inspector select[data-picture=${side}]`), others = [...picks('a').options].map(o => o.value);
        button('difference').click();
        await slide(-9);
        await choose(picks('b'), picks('a').value, 'change');
        const none = above();
        await choose(picks('b'), others.find(name => /gl/.test(name) && name !== picks('a').value && !data.agreement.some(r => [r.image_a, r.image_b].includes(name) && [r.image_a, r.image_b].includes(picks('a').value))), 'change');
        const rough = shown()[0].parentElement.textContent.includes('8-bit');
        say('any_two_pictures', others.length > 2 && none === 0 && rough);
        say('fetched', performance.getEntriesByType('resource').filter(r => !r.name.startsWith('data:')).length);
        say('pictures_broken', [...document.images].filter(i => i.complete && i.naturalWidth === 0).length);
    } catch (problem) {
        say('exception', problem.message);
    }
    const out = document.createElement('pre');
    out.id = 'findings';
    out.textContent = `\nfindings\n${lines.join('\n')}\nend of findings\n`;
    document.body.append(out);
})();
