// SPDX-License-Identifier: MIT
// caster.js - renders a picture of a level with raycast.glsl, like raycaster.c and gl_uniforms.c.
// 
// A request: {level, code: name, null for differences of the scalar, or vectors for those of the level; adapted, tf or
// table, camera, lights, shading, background, clips, step, width, height}. A level's textures are made on first use.
const onTheFlyEps = 1e-4; // ISO_ON_THE_FLY_EPS

const makeCaster = (context, data) => {
    const {gl} = context, tables = new Map();

    // A level's transfer function: its table as a texture, and the visible bricks; the last few are cached.
    const tableOf = (level, tf, adapted, given) => {
        const key = given ? 'given' : `${level.level} ${adapted} ${JSON.stringify(tf)}`;
        if (tables.has(key)) return tables.get(key);
        let table = given || tabulate(tf, data.value_range, data.mean_spacing_mm);
        if (adapted && level.adapter) table = adaptTable(level.adapter, table, data.mean_spacing_mm);
        if (data.has_no_data) table = endedBelow(table, data.value_range[0]);
        const ranges = level.ranges ??= brickRanges(level.numbers, level.size);
        const made = {...table, bricks: occupancyOf(ranges, level.scalar, table), texture: uploadTable(context, table)};
        tables.set(key, made);
        if (tables.size > 6) {
            const [oldest, old] = tables.entries().next().value;
            gl.deleteTexture(old.texture);
            if (old.occupancy) gl.deleteTexture(old.occupancy);
            tables.delete(oldest);
        }
        return made;
    };
    const scalarOf = level => level.scalarTexture ??= allSteps(uploadScalar(context, level));
    const codeOf = (level, name) => {
        const code = level.codes.find(c => c.name === name);
        if (code) code.texture ??= allSteps(uploadCodes(context, level, code));
        return code;
    };

    // A finer level inside a box of the one around it: roi.glsl.
    const setRoi = (program, q, scalar, table) => {
        const {level, roi} = q, fine = roi.level, times = 2 ** (level.level - fine.level);
        const entries = (table.count - 1) / (table.hi - table.lo), index = roi.box.map(corner => corner.map((part, a) => part * level.box_index[a]));
        program.int('roi_scalar', 4);
        program.int('roi_directions', 5);
        program.int('roi_tf', 6);
        program.float('roi_tf_scale', scalar.perTexel * entries);
        program.float('roi_tf_offset', (fine.scalar.zero - table.lo) * entries);
        program.int('roi_tf_count', table.count);
        program.vec3('roi_place_scale', level.size.map((n, a) => times * n / fine.size[a]));
        program.vec3('roi_place_offset', [0, 0, 0]);
        program.vec3('roi_lo', index[0]);
        program.vec3('roi_hi', index[1]);
        program.float('roi_band', roi.band);
        program.vec3('index_per_p', level.size);
    };
    const setCamera = (program, q, g, over) => {
        const axes = axesOf(q.camera), {width, height} = q, half = q.camera.half, clips = q.clips.map(c => clipInIndex(c, data.geometry0, g));
        program.mat3('to_index', inverse(g.index_to_world));
        program.vec2('image_size', [width, height]);
        program.vec2('first_pixel', [0, q.firstRow ?? 0]);
        program.vec2('half_image', [half * width / height, half]);
        program.int('orthographic', q.camera.orthographic);
        for (const name of ['forward', 'right', 'up']) program.vec3(name, axes[name]);
        program.vec3('position_index', toIndex(g, q.camera.position));
        program.vec3('box_index', g.box_index);
        const finest = Math.min(...[q.roi?.level ?? g, over].filter(Boolean).flatMap(spacings));
        program.float('step_mm', q.step * finest);
        const side = g.brick_voxels;
        program.vec3('index_scale', g.isPlan ? [1 / side, 1 / side, 1 / side] : g.size.map(n => 1 / n));
        program.vec3('index_offset', g.isPlan ? [-0.5 / side, -0.5 / side, -0.5 / side] : [0, 0, 0]);
        program.int('clip_count', clips.length);
        if (clips.length) program.vec4('clip_planes[0]', clips.flat());
        const lights = q.lights.map(l => lightInWorld(l, axes));
        if (lights.length) program.vec3('light_direction[0]', lights.flat());
        if (lights.length) program.floats('light_intensity[0]', q.lights.map(l => l.intensity ?? 1));
        program.vec4('shading', [q.shading.ambient, q.shading.diffuse, q.shading.specular ?? 0, q.shading.power ?? 20]);
        program.vec3('background', q.background);
    };
    const setField = (program, level, scalar, code, table) => {
        const g = level, entries = (table.count - 1) / (table.hi - table.lo), range = level.max - level.min;
        program.int('scalar', 0);
        program.int('tf', 1);
        program.int('directions', 2);
        program.int('occupancy', 3);
        program.float('tf_scale', scalar.perTexel * entries);
        program.float('tf_offset', (level.scalar.zero - table.lo) * entries);
        program.int('tf_count', table.count);
        program.int('labels', level.labels); // if filtered by hand
        program.vec3('voxel', g.size.map(n => 1 / n));
        program.vec3('bricks_per_volume', g.isPlan ? [1, 1, 1] : g.size.map(n => n / brickVoxels));
        if (g.isPlan) {
            program.int('layout_of_bricks', 7);
            program.vec3('brick_in_cache', g.texels.map(n => g.brick_voxels / n));
            program.vec3('last_node', g.size.map(n => (n - 1) / g.brick_voxels));
        }
        if (code) {
            program.float('direction_scale', code.texture.scale);
            program.float('direction_offset', code.texture.offset);
        }
        const factor = range > 0 ? 0.5 * scalar.perTexel * Math.min(...spacings(g)) / range : 0;
        program.mat3('gradient_to_world', transpose(inverse(g.index_to_world)).map(row => scale(row, factor)));
        program.float('on_the_fly_eps', onTheFlyEps);
        program.int('extinction_scale', 8);
        program.float('octaves_per_texel', 1 / scaleBytes.perOctave);
        program.float('octaves_offset', -scaleBytes.one / scaleBytes.perOctave);
    };
    const bind = (unit, kind, texture) => { gl.activeTexture(gl.TEXTURE0 + unit); gl.bindTexture(kind, texture); };

    // The program of a request, as context.program() and context.compiled() take it.
    const programOf = (q, scalar, skip, over) => {
        const {level} = q, code = q.code ? level.codes.find(c => c.name === q.code) : null;
        const byHand = scalar.byHand || (over && scalarOf(over).byHand) || (q.vectors && !context.floatFilter);
        return [['code_decode.h', 'raycast.glsl', ...over ? ['overlay.glsl'] : []], {
            DIRECTION_SOURCE: code ? 'SOURCE_CODES' : q.vectors ? 'SOURCE_VECTORS' : 'SOURCE_ON_THE_FLY',
            DECODER: code ? code.decoder : 'ISO_DECODER_LINEAR', OUTPUT: 'OUTPUT_INTEGRAL', LIGHT_COUNT: q.lights.length,
            SPECULAR: Number((q.shading.specular ?? 0) > 0), SHADE_TABLE: 0, SKIP_EMPTY: Number(skip), SCREEN_TILE: 0,
            PREINTEGRATED: 0, EXACT: 0, ROI: Number(Boolean(q.roi)), BRICKS: Number(Boolean(level.isPlan)), TF_2D_ROWS: 0,
            EXTINCTION_SCALE: level.share ? 'SCALE_ALONE' : 'SCALE_NONE', SCALAR_WITH_DIRECTIONS: 0, PAGES: 1,
            FILTERED_BY_HAND: byHand ? 1 : undefined, OVERLAY: over ? 1 : undefined,
        }];
    };
    const overOf = q => shownOverlay(context, data.overlay?.level, q.overlay);
    // A brick may be empty in one of two levels only.
    const skips = q => !q.roi && Math.min(tableOf(q.level, q.tf, q.adapted, q.table).bricks.part, overOf(q)?.table.bricks.part ?? 1) <= skipOccupied;
    const occupancyTexture = table => table.occupancy ??= uploadOccupancy(context, table.bricks);
    // Resolves when the program of a request is compiled.
    const compiled = q => context.compiled(...programOf(q, scalarOf(q.level), skips(q), overOf(q)));
    // Uploads a level's textures before they are needed, in steps. The level is not shown yet.
    const prepare = async (level, numbers, codeName) => {
        const {begun} = context, code = level.codes.find(c => c.name === codeName);
        level.scalarTexture = await slowSteps(uploadScalar(context, {...level, numbers}), context);
        if (code) code.texture = await slowSteps(uploadCodes(context, level, code), context);
        // Textures of a context that was lost meanwhile are made when they are drawn.
        if (begun !== context.begun || gl.isContextLost()) level.scalarTexture = (code ?? {}).texture = undefined;
    };

    // Draws rows [from, to) of the target. With q.height the target holds only a part of a picture of this height, from
    // q.firstRow.
    const draw = (q, target, from = 0, to = target.height) => {
        const {level} = q, scalar = scalarOf(level), code = q.code ? codeOf(level, q.code) : null;
        const table = tableOf(level, q.tf, q.adapted, q.table), skip = skips(q);
        const vectors = q.vectors ? level.vectorTexture ??= uploadVectors(context, level) : null;
        const fine = q.roi ? {scalar: scalarOf(q.roi.level), code: codeOf(q.roi.level, q.code), table: tableOf(q.roi.level, q.tf, q.adapted && q.roi.level.level > 0)} : null;
        const over = overOf(q), program = context.program(...programOf(q, scalar, skip, over));
        program.use();
        setCamera(program, {...q, width: target.width, height: q.height ?? target.height}, level, over);
        setField(program, level, scalar, code, table);
        bind(0, gl.TEXTURE_3D, scalar.texture);
        bind(1, gl.TEXTURE_2D, table.texture);
        if (code) bind(2, gl.TEXTURE_3D, code.texture.texture);
        if (vectors) bind(2, gl.TEXTURE_3D, vectors);
        if (skip) bind(3, gl.TEXTURE_3D, occupancyTexture(table));
        if (level.share) bind(8, gl.TEXTURE_3D, level.shareTexture ??= uploadShare(context, level));
        if (level.isPlan) bind(7, gl.TEXTURE_3D, level.layoutTexture ??= uploadLayout(context, level));
        if (over) {
            setOverlay(program, q.camera, over, scalarOf(over));
            bind(11, gl.TEXTURE_3D, over.scalarTexture.texture);
            bind(12, gl.TEXTURE_2D, over.table.texture);
            if (skip) bind(13, gl.TEXTURE_3D, occupancyTexture(over.table));
        }
        if (fine) {
            setRoi(program, q, fine.scalar, fine.table);
            bind(4, gl.TEXTURE_3D, fine.scalar.texture);
            bind(5, gl.TEXTURE_3D, fine.code.texture.texture);
            bind(6, gl.TEXTURE_2D, fine.table.texture);
        }
        gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
        gl.viewport(0, 0, target.width, target.height);
        gl.enable(gl.SCISSOR_TEST);
        gl.scissor(0, from, target.width, to - from);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        gl.disable(gl.SCISSOR_TEST);
    };
    const bytes = () => data.levels.reduce((sum, l) => sum + (l.scalarTexture?.bytes ?? 0) + (l.codes || []).reduce((s, c) => s + (c.texture?.bytes ?? 0), 0), 0);
    // Frees all textures: for another volume, and after the context was lost.
    const forget = levels => {
        for (const table of tables.values()) {
            gl.deleteTexture(table.texture);
            if (table.occupancy) gl.deleteTexture(table.occupancy);
        }
        tables.clear();
        for (const l of levels) {
            for (const t of [l.scalarTexture, ...l.codes.map(c => c.texture)]) if (t) gl.deleteTexture(t.texture);
            if (l.layoutTexture) gl.deleteTexture(l.layoutTexture);
            if (l.shareTexture) gl.deleteTexture(l.shareTexture);
            for (const texture of [l.table?.texture, l.table?.occupancy]) if (texture) gl.deleteTexture(texture);
            l.table = l.tableKey = undefined;
            l.scalarTexture = l.layoutTexture = l.shareTexture = undefined;
            for (const code of l.codes) code.texture = undefined;
        }
    };
    return {draw, compiled, prepare, bytes, tableOf, forget};
};
