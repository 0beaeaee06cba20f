// SPDX-License-Identifier: MIT
// context.js - WebGL2: programs of the shared shader sources, float targets, and the precision of texture filters.
const makeContext = canvas => {
    const gl = canvas.getContext('webgl2', {alpha: false, antialias: false, depth: false, powerPreference: 'high-performance'});
    if (!gl) return null;
    const sources = JSON.parse(document.getElementById('shaders').textContent), programs = new Map();
    const context = {gl, floatTarget: Boolean(gl.getExtension('EXT_color_buffer_float')), floatFilter: Boolean(gl.getExtension('OES_texture_float_linear'))};
    if (!context.floatTarget) gl.getExtension('EXT_color_buffer_half_float');
    const unmasked = gl.getExtension('WEBGL_debug_renderer_info');
    context.renderer = gl.getParameter(unmasked ? unmasked.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    context.most = gl.getParameter(gl.MAX_3D_TEXTURE_SIZE);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.bindVertexArray(gl.createVertexArray());

    // GLSL has no includes: replaces lines #include "NAME" by that file, like gl_program.c. Files of variants that the
    // page does not use are missing.
    const expand = name => (sources[name] ?? '').replace(/^#include "([^"\n]+)"$/gm, (line, included) => expand(included));
    const compile = (stage, text, name) => {
        const shader = gl.createShader(stage);
        gl.shaderSource(shader, text);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
            throw new Error(`shader ${name} does not compile: ${gl.getShaderInfoLog(shader)}`);
        return shader;
    };
    // defines: an object; undefined values are left out. parts: the files after es.glsl.
    context.program = (parts, defines = {}) => {
        const lines = Object.entries(defines).filter(([, v]) => v !== undefined).map(([k, v]) => `#define ${k} ${v}\n`).join('');
        const key = parts.join() + lines;
        if (programs.has(key)) return programs.get(key);
        const head = '#version 300 es\n' + expand('es.glsl'), name = gl.createProgram();
        gl.attachShader(name, compile(gl.VERTEX_SHADER, head + expand('fullscreen.glsl'), 'fullscreen.glsl'));
        gl.attachShader(name, compile(gl.FRAGMENT_SHADER, head + lines + parts.map(expand).join('\n'), parts[parts.length - 1]));
        gl.linkProgram(name);
        if (!gl.getProgramParameter(name, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(`shaders do not link: ${gl.getProgramInfoLog(name)}`);
        const places = new Map(), place = n => places.get(n) ?? (places.set(n, gl.getUniformLocation(name, n)), places.get(n));
        const program = {
            name, use: () => gl.useProgram(name),
            int: (n, v) => gl.uniform1i(place(n), v), float: (n, v) => gl.uniform1f(place(n), v), vec2: (n, v) => gl.uniform2fv(place(n), v),
            vec3: (n, v) => gl.uniform3fv(place(n), v), vec4: (n, v) => gl.uniform4fv(place(n), v), floats: (n, v) => gl.uniform1fv(place(n), v),
            mat3: (n, m) => gl.uniformMatrix3fv(place(n), false, transpose(m).flat()), // columns
        };
        programs.set(key, program);
        return program;
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
        throw new Error(`no target of ${width} x ${height} pixels`);
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
    context.bits = context.floatTarget ? probeFilters(context) : {r8: 8, r8snorm: 8, r16f: 8, r32f: context.floatFilter ? 8 : 0};
    return context;
};

// Bits that linear filtering between texels 0 and 1 keeps, probed like in gl_context.c. If 8-bit textures keep fewer
// (software), bytes are stored as half floats, which hold them exactly.
const probeFilters = context => {
    const {gl} = context, count = 1021, target = context.target(count, 1), program = context.program(['probe.glsl']), bits = {};
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
        const out = context.read(target);
        let worst = 2 ** -24;
        for (let i = 0; i < count; ++i) worst = Math.max(worst, Math.abs(out[4 * i] - (i + 0.5) / count));
        bits[name] = Math.round(-Math.log2(worst)) - 1;
        gl.deleteTexture(texture);
    }
    target.free();
    return bits;
};
