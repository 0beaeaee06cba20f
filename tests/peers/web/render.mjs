// SPDX-License-Identifier: MIT
// A renderer of isoshade's contract (doc/guide/judging-a-renderer.md): a library of the web draws the request in headless Chromium.
//   node render.mjs LIBRARY [--gl egl|swiftshader] [--change NAME]... REQUEST.json
//   node render.mjs LIBRARY --version
// Changes are for experiments alone: each takes one cause of a difference away (doc/results/web.md).
import {existsSync, readFileSync} from 'node:fs';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath, pathToFileURL} from 'node:url';

import {chromiumVersion, drawers, withPage} from './chromium.mjs';
import {readNrrdHeader, writeExr} from './files.mjs';

const here = dirname(fileURLToPath(import.meta.url)), [library, ...options] = process.argv.slice(2);
const fetched = join(here, '../../../build/web');
const packages = {vtkjs: ['vtk.js', '@kitware/vtk.js'], niivue: ['NiiVue', '@niivue/niivue']};

const version = () => {
    const [title, name] = packages[library];
    const {version: number} = JSON.parse(readFileSync(join(fetched, 'node_modules', name, 'package.json')));
    return `${title} ${number}, ${chromiumVersion()}`;
};

// Bottom row first, as OpenGL reads it; to the first row on top.
const picture = (pixels, width, height, most) => {
    const rgba = new Float32Array(4 * width * height);
    for (let y = 0; y < height; ++y)
        for (let i = 0; i < 4 * width; ++i)
            rgba[4 * width * y + i] = pixels[4 * width * (height - 1 - y) + i] / most;
    return rgba;
};

const render = async (path, gl, changes) => {
    const request = JSON.parse(readFileSync(path)), folder = dirname(resolve(path)), {width, height} = request.image;
    if (request.schema !== 'isoshade.request/1')
        throw new Error(`${path}: "${request.schema}" is not isoshade.request/1`);
    const file = join(folder, request.volume.file), header = readNrrdHeader(file);
    const asked = {...request, changes, samples: {...header, url: pathToFileURL(file).href}};
    await withPage(join(fetched, `${library}.html`), gl, async call => {
        await call('prepare', asked);
        for (const frame of request.frames) {
            const {base64, floats} = await call('draw', frame), bytes = Buffer.from(base64, 'base64');
            const pixels = floats ? new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4) : bytes;
            writeExr(join(folder, frame.file), picture(pixels, width, height, floats ? 1 : 255), width, height);
        }
    });
};

try {
    if (!(library in packages))
        throw new Error(`render.mjs: the libraries are ${Object.keys(packages).join(' and ')}`);
    if (!existsSync(join(fetched, `${library}.html`)))
        throw new Error(`${packages[library][0]} is not here: sh ${join(here, 'fetch.sh')} fetches it`);
    const after = name => options.filter((_, i) => options[i - 1] === name), [gl = 'egl'] = after('--gl');
    if (!drawers.includes(gl))
        throw new Error(`--gl is one of ${drawers.join(' and ')}`);
    if (options[0] === '--version')
        console.log(version());
    else
        await render(options.at(-1), gl, after('--change'));
} catch (error) {
    console.error(error.message);
    process.exitCode = 1;
}
