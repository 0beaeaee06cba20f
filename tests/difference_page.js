// SPDX-License-Identifier: MIT
// Uses the page of two reports as its reader does, and writes a line a finding into it, for tests/check_report_diff.sh to read.
(async () => {
    const lines = [], say = (name, value) => lines.push(`${name} ${value}`);
    const $ = selector => document.querySelector(selector), settle = () => new Promise(done => setTimeout(done, 150));
    const button = text => [...document.querySelectorAll('#inspector button')].find(b => b.textContent.startsWith(text));
    const canvases = () => [...document.querySelectorAll('#inspector canvas[tabindex]')], shown = () => canvases().filter(c => !c.parentElement.hidden);
    // How many pixels of the canvas that is shown are not those of an earlier one.
    const bytes = () => { const c = shown()[0]; return {width: c.width, height: c.height, data: c.getContext('2d').getImageData(0, 0, c.width, c.height).data}; };
    const changed = (a, b, from, to) => {
        let count = 0;
        for (let y = 0; y < a.height; ++y) for (let x = Math.ceil(from * a.width); x < to * a.width; ++x) count += a.data[4 * (y * a.width + x)] !== b.data[4 * (y * a.width + x)];
        return count;
    };
    try {
        while (document.documentElement.dataset.ready !== 'yes') await settle();
        await settle();
        say('changes', document.querySelectorAll('#rows tbody tr[data-change]').length);
        say('pictures', document.querySelectorAll('#pictures tbody tr').length);
        say('verdict', $('#verdict').textContent);
        say('begins_with_a_flip', shown().length === 1 && button('flip').getAttribute('aria-pressed') === 'true');
        const a = bytes();
        button('swap').click();
        await settle();
        const b = bytes();
        say('flips_between_the_reports', changed(a, b, 0, 1) > 0 && /^B: /.test(shown()[0].parentElement.textContent));
        button('slider').click();
        const slide = async to => { const s = $('#inspector input[aria-label^=where]'); s.value = to; s.dispatchEvent(new Event('input')); await settle(); return bytes(); };
        const half = await slide(0.5), all = await slide(0), none = await slide(1);
        say('slider', changed(half, a, 0, 0.49) === 0 && changed(half, b, 0.51, 1) === 0 && changed(all, b, 0.01, 1) === 0 && changed(none, a, 0, 0.99) === 0);
        button('difference').click();
        await settle();
        say('differing_pixels', /(\d+) of/.exec(shown()[0].parentElement.textContent)[1]);
        button('side').click();
        await settle();
        say('side_by_side', shown().length);
        $('#rows button.open').click();
        await settle();
        say('a_row_opens_its_picture', location.hash.startsWith('#case-'));
        say('elements_of_the_name', document.querySelectorAll('main b').length - [...document.querySelectorAll('main b')].filter(e => /^(Table|Figure) /.test(e.textContent)).length);
        say('name_is_text', document.body.textContent.includes('<b>|x'));
        say('controls_without_a_name', [...document.querySelectorAll('button, select, input')].filter(e => !e.textContent.trim() && !e.getAttribute('aria-label')).length);
        say('fetched', performance.getEntriesByType('resource').filter(e => !/^(data|blob):/.test(e.name)).length);
    } catch (e) { say('exception', e.stack); }
    document.body.append(Object.assign(document.createElement('pre'), {textContent: ['', 'findings', ...lines, 'end of findings', ''].join('\n')}));
})();
