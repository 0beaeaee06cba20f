// SPDX-License-Identifier: MIT
// Headless Chromium as a function: opens a page of this machine and calls what stands in it. Its protocol goes through two
// pipes, so no port is opened, and the browser ends where these end.
import {spawn, spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';

const program = process.env.CHROMIUM || 'chromium';

// SwiftShader, which comes with Chromium, draws on the processor and the same on every machine; "egl" is the machine's own
// OpenGL. A page of this machine may read the files beside it.
const drawnBy = {
    swiftshader: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
    egl: ['--use-angle=gl-egl', '--ignore-gpu-blocklist'],
};
export const drawers = Object.keys(drawnBy);
const flags = (folder, gl) => [
    '--headless=new', '--no-sandbox', '--disable-gpu-sandbox', '--use-gl=angle', ...drawnBy[gl], '--no-first-run', '--disable-background-networking', '--disable-component-update',
    '--disable-default-apps', '--disable-extensions', '--disable-sync', '--mute-audio', '--force-device-scale-factor=1',
    '--force-color-profile=srgb', '--allow-file-access-from-files', `--user-data-dir=${folder}`,
    '--remote-debugging-pipe', 'about:blank',
];

export const chromiumVersion = () => {
    const said = spawnSync(program, ['--version'], {encoding: 'utf8'});
    if (said.error || said.status !== 0)
        throw new Error(`${program} does not start: ${said.error ? said.error.message : said.stderr}`);
    return said.stdout.trim().split(' ').slice(0, 2).join(' ');
};

// gl: one of the drawers. work(call): call(name, argument) calls window[name](argument) in the page and gives what its promise gives.
export const withPage = async (page, gl, work) => {
    const folder = mkdtempSync(join(tmpdir(), 'isoshade-web-'));
    const browser = spawn(program, flags(folder, gl), {stdio: ['ignore', 'ignore', 'pipe', 'pipe', 'pipe']});
    const [, , , toBrowser, fromBrowser] = browser.stdio;
    const waiting = new Map(), said = [];
    let number = 0, rest = [], loaded, ended = null;
    const isLoaded = new Promise(done => { loaded = done; });
    const fail = why => {
        ended = new Error(why);
        waiting.forEach(({no}) => no(ended));
        waiting.clear();
    };
    const gone = new Promise(done => browser.on('close', done));
    browser.stderr.on('data', text => { said.push(text); });
    browser.on('error', error => fail(`${program} does not start: ${error.message}`));
    browser.on('exit', () => fail(`${program} ended: ${Buffer.concat(said).toString().slice(-600)}`));
    toBrowser.on('error', () => {});
    const hear = message => {
        if (message.method === 'Page.loadEventFired')
            loaded();
        if (message.method === 'Runtime.consoleAPICalled')
            console.log(message.params.type, ...message.params.args.map(a => a.value ?? a.description));
        const asked = waiting.get(message.id);
        waiting.delete(message.id);
        if (asked)
            message.error ? asked.no(new Error(message.error.message)) : asked.yes(message.result);
    };
    fromBrowser.on('data', data => {
        for (let at; (at = data.indexOf(0)) >= 0; data = data.subarray(at + 1)) {
            hear(JSON.parse(Buffer.concat([...rest, data.subarray(0, at)]).toString()));
            rest = [];
        }
        rest.push(data);
    });
    const ask = (method, params = {}, sessionId = undefined) => ended ? Promise.reject(ended) : new Promise((yes, no) => {
        waiting.set(++number, {yes, no});
        toBrowser.write(`${JSON.stringify({id: number, method, params, sessionId})}\0`);
    });
    const end = () => { browser.kill('SIGKILL'); };
    const interrupted = () => { end(); process.exit(1); };
    process.once('SIGTERM', interrupted).once('SIGINT', interrupted);
    try {
        const {targetInfos} = await ask('Target.getTargets');
        const {targetId} = targetInfos.find(t => t.type === 'page');
        const {sessionId} = await ask('Target.attachToTarget', {targetId, flatten: true});
        await ask('Page.enable', {}, sessionId);
        await ask('Runtime.enable', {}, sessionId);
        await ask('Page.navigate', {url: pathToFileURL(page).href}, sessionId);
        await isLoaded;
        const call = async (name, argument) => {
            const {result, exceptionDetails} = await ask('Runtime.evaluate',
                {expression: `${name}(${JSON.stringify(argument)})`, awaitPromise: true, returnByValue: true}, sessionId);
            if (exceptionDetails)
                throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
            return result.value;
        };
        return await work(call);
    } finally {
        process.off('SIGTERM', interrupted).off('SIGINT', interrupted);
        end();
        await gone;
        rmSync(folder, {recursive: true, force: true, maxRetries: 5});
    }
};
