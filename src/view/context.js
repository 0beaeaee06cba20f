// SPDX-License-Identifier: MIT
// context.js - WebGL2: programs of the shared shader sources, float targets, and the precision of texture filters. The
// page goes on while the graphics card works: it asks from time to time, and reads only what is done.
const pause = () => new Promise(done => setTimeout(done, 0));
const makeContext = async canvas => {
    const gl = canvas.getContext('webgl2', {alpha: false, antialias: false, depth: false, powerPreference: 'high-performance'});
    if (!gl) return null;
    const sources = JSON.parse(document.getElementById('shaders').textContent), programs = new Map();
    const context = {gl, begun: 0}; // how often its objects were made
    let parallel = null; // compiles beside the page
    // At first, and after the context was lost.
    context.begin = () => {
        ++context.begun;
        context.floatTarget = Boolean(gl.getExtension('EXT_color_buffer_float'));
        context.floatFilter = Boolean(gl.getExtension('OES_texture_float_linear'));
        if (!context.floatTarget) gl.getExtension('EXT_color_buffer_half_float');
        parallel = gl.getExtension('KHR_parallel_shader_compile');
        programs.clear();
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        gl.bindVertexArray(gl.createVertexArray());
    };
    context.begin();
    // Resolves when the commands so far are done.
    context.finished = async () => {
        const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
        gl.flush();
        const isDone = () => gl.isContextLost() || gl.getSyncParameter(sync, gl.SYNC_STATUS) === gl.SIGNALED;
        while (!isDone()) await pause();
        gl.deleteSync(sync);
    };
    const unmasked = gl.getExtension('WEBGL_debug_renderer_info');
    context.renderer = gl.getParameter(unmasked ? unmasked.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    context.most = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE);

    // GLSL has no includes: replaces lines #include "NAME" by that file, like gl_program.c. Files of variants that the
    // page does not use are missing.
    const expand = name => (sources[name] ?? '').replace(/^#include "([^"\n]+)"$/gm, (line, included) => expand(included));
    const compile = (stage, text) => {
        const shader = gl.createShader(stage);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        return shader;
    };
    const begin = (parts, lines) => {
        const head = '#version 300 es\n' + expand('es.glsl'), name = gl.createProgram();
        const texts = [head + expand('fullscreen.glsl'), head + lines + parts.map(expand).join('\n')];
        const shaders = texts.map((text, i) => compile([gl.VERTEX_SHADER, gl.FRAGMENT_SHADER][i], text));
        for (const shader of shaders) gl.attachShader(name, shader);
        gl.linkProgram(name);
        return {name, shaders, parts};
    };
    const check = ({name, shaders, parts}) => {
        if (gl.isContextLost() || gl.getProgramParameter(name, gl.LINK_STATUS)) return;
        const log = shaders.map(shader => gl.getShaderInfoLog(shader)).join('') || gl.getProgramInfoLog(name);
        throw new Error(`shader ${parts[parts.length - 1]} does not compile: ${log}`);
    };
    const callsOf = name => {
        const places = new Map();
        const place = n => places.get(n) ?? (places.set(n, gl.getUniformLocation(name, n)), places.get(n));
        return {
            use: () => gl.useProgram(name),
            int: (n, v) => gl.uniform1i(place(n), v), float: (n, v) => gl.uniform1f(place(n), v),
            vec2: (n, v) => gl.uniform2fv(place(n), v), vec3: (n, v) => gl.uniform3fv(place(n), v),
            vec4: (n, v) => gl.uniform4fv(place(n), v), floats: (n, v) => gl.uniform1fv(place(n), v),
            mat3: (n, m) => gl.uniformMatrix3fv(place(n), false, transpose(m).flat()), // columns
        };
    };
    // defines: an object; undefined values are left out. parts: the files after es.glsl.
    const started = (parts, defines) => {
        const given = Object.entries(defines).filter(([, value]) => value !== undefined);
        const lines = given.map(([k, value]) => `#define ${k} ${value}\n`).join(''), key = parts.join() + lines;
        if (!programs.has(key)) programs.set(key, begin(parts, lines));
        return programs.get(key);
    };
    context.program = (parts, defines = {}) => {
        const program = started(parts, defines);
        if (!program.use) {
            check(program);
            Object.assign(program, callsOf(program.name));
        }
        return program;
    };
    context.compiled = async (parts, defines = {}) => {
        const {name} = started(parts, defines);
        const isDone = () => gl.isContextLost() || gl.getProgramParameter(name, parallel.COMPLETION_STATUS_KHR);
        while (parallel && !isDone()) await pause();
        return context.program(parts, defines);
    };

    // A picture in linear light; 8 bits only if the browser has no float targets.
    context.target = (width, height, {bytes = false} = {}) => {
        const texture = gl.createTexture(), frame = gl.createFramebuffer();
        const floats = [[gl.RGBA32F, gl.FLOAT, context.floatTarget], [gl.RGBA16F, gl.HALF_FLOAT, true]];
        const forms = [...(bytes ? [] : floats), [gl.RGBA8, gl.UNSIGNED_BYTE, true]];
        for (const [format, type, may] of forms) {
            if (!may) continue;
            gl.activeTexture(gl.TEXTURE8);
            gl.bindTexture(gl.TEXTURE_2D, texture);
            gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RGBA, type, null);
            const smooth = format === gl.RGBA32F && !context.floatFilter ? gl.NEAREST : gl.LINEAR;
            for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, smooth], [gl.TEXTURE_MAG_FILTER, smooth], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
                gl.texParameteri(gl.TEXTURE_2D, key, value);
            gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
            if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE)
                return {texture, frame, width, height, type, free: () => { gl.deleteTexture(texture); gl.deleteFramebuffer(frame); }};
        }
        throw new Error(gl.isContextLost() ? 'the graphics card stopped this page; try again when the picture is back'
            : `no target of ${width} x ${height} pixels`);
    };
    context.read = (target, x = 0, y = 0, width = target.width, height = target.height) => {
        const bytes = target.type === gl.UNSIGNED_BYTE, out = new (bytes ? Uint8Array : Float32Array)(4 * width * height);
        gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
        gl.readPixels(x, y, width, height, gl.RGBA, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, out);
        return out;
    };
    context.volume = (unit, format, size) => {
        const texture = gl.createTexture();
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_3D, texture);
        gl.texStorage3D(gl.TEXTURE_3D, 1, format, ...size);
        for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) gl.texParameteri(gl.TEXTURE_3D, wrap, gl.CLAMP_TO_EDGE);
        context.filter(gl.LINEAR);
        return texture;
    };
    context.filter = how => {
        gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MIN_FILTER, how);
        gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MAG_FILTER, how);
    };
    context.bits = context.floatTarget ? await probeFilters(context) : {r8: 8, r8snorm: 8, r16f: 8, r32f: context.floatFilter ? 8 : 0};
    return context;
};

// Bits that linear filtering between texels 0 and 1 keeps, probed like in gl_context.c. If 8-bit textures keep fewer
// (software), bytes are stored as half floats, which hold them exactly.
const probeFilters = async context => {
    const {gl} = context, count = 1021, target = context.target(count, 1), bits = {};
    const program = await context.compiled(['probe.glsl']);
    const forms = {r8: [gl.R8, gl.UNSIGNED_BYTE, new Uint8Array([0, 255])], r8snorm: [gl.R8_SNORM, gl.BYTE, new Int8Array([0, 127])], r16f: [gl.R16F, gl.FLOAT, new Float32Array([0, 1])]};
    if (context.floatFilter) forms.r32f = [gl.R32F, gl.FLOAT, new Float32Array([0, 1])];
    for (const [name, [format, type, texels]] of Object.entries(forms)) {
        const texture = context.volume(0, format, [2, 1, 1]);
        gl.texSubImage3D(gl.TEXTURE_3D, 0, 0, 0, 0, 2, 1, 1, gl.RED, type, texels);
        program.use();
        program.int('texels', 0);
        program.float('count', count);
        gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
        gl.viewport(0, 0, count, 1);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        await context.finished();
        const out = context.read(target);
        let worst = 2 ** -24;
        for (let i = 0; i < count; ++i) worst = Math.max(worst, Math.abs(out[4 * i] - (i + 0.5) / count));
        bits[name] = Math.round(-Math.log2(worst)) - 1;
        gl.deleteTexture(texture);
    }
    target.free();
    return bits;
};
