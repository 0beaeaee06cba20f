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
    const above = () => Number(/(\d+) of/.exec($('#inspector canvas[aria-label=difference]').parentElement.textContent)[1]);
    const slide = async value => {
        const slider = $('#inspector input[type=range]');
        slider.value = value;
        slider.dispatchEvent(new Event('input'));
        await settle();
    };
    try {
        while (document.documentElement.dataset.ready !== 'yes') await settle();
        await settle();
        const failed = $('#failed'), rows = [...document.querySelectorAll('#agreement tbody tr')];
        say('failed_cases_shown', !failed.hidden && failed.querySelectorAll('.failure').length);
        say('failed_cases_on_top', Boolean(failed.compareDocumentPosition($('#agreement')) & Node.DOCUMENT_POSITION_FOLLOWING));
        say('rows', rows.length === data.agreement.length && rows.length);
        say('worst_row_first', rows[0].lastElementChild.textContent);
        say('reproduce', $('#failed .command code').textContent);
        say('panels_side_by_side', shown().length);

        await slide(-9);
        const all = above();
        await slide(0);
        say('threshold', all > 0 && above() === 0);
        await slide(-9);

        const whole = pictures();
        canvases()[0].dispatchEvent(new WheelEvent('wheel', {deltaY: -400, clientX: 10, clientY: 10, cancelable: true}));
        await settle();
        const zoomed = pictures();
        say('zoom_in_step', zoomed.filter((p, i) => p !== whole[i]).length);
        button('whole').click();
        await settle();
        say('whole_again', pictures().every((p, i) => p === whole[i]));

        button('flip').click();
        await settle();
        const a = shown();
        button('swap').click();
        await settle();
        const b = shown();
        say('flip', a.length === 1 && b.length === 1 && a[0] !== b[0]);
        button('side').click();

        say('versions_and_machine', /Versions/.test($('#colophon').textContent) && /Machine/.test($('#colophon').textContent));
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
