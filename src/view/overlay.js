// SPDX-License-Identifier: MIT
// overlay.js - a second volume over the slices and in the picture, with a transfer function of its own.
//
// data.overlay is {level, name}; its settings are state.overlay: {cover, range, tf}. Without a tf, labels have a hue
// each, and 0 is clear; other values glow from red to white over the range, and are clear below it. Integers from 0 to
// 255 in an opened file are labels.
const isLabelLevel = level => level.scalar.kind === 'integer' && level.min === 0 && level.max <= 255;
const overlaySettings = () => ({cover: 0.6, range: null, tf: null});
const overlayRange = (level, {range}) => {
    const [lo, hi] = usualWindow(level);
    return range ?? [(lo + hi) / 2, hi];
};

// The transfer function of an overlay. Its opacities are over one voxel.
const overlayTf = (level, settings) => {
    if (settings.tf) return settings.tf;
    const [lo, hi] = overlayRange(level, settings);
    const glow = [[1, 0, 0], [1, 0.5, 0], [1, 1, 0], [1, 1, 1]], wave = h => clamp(Math.abs((h % 6) - 3) - 1, 0, 1);
    // A golden angle from one to the next.
    const hue = value => [0, 4, 2].map(turn => toLinear(wave(value * 2.2918 + turn)));
    const glowing = glow.map((rgb, i) => ({value: lo + i / 3 * (hi - lo), rgb, opacity: 1}));
    const isLabels = level.labels, points = isLabels
        ? Array.from({length: level.max + 1}, (_, value) => ({value, rgb: hue(value), opacity: Number(value > 0)}))
        : [{value: lo, rgb: glow[0], opacity: 0}, ...glowing];
    return {
        range: [level.min, level.max > level.min ? level.max : level.min + 1], unit_distance_voxels: 1,
        table_size: isLabels ? clamp(level.max + 1, 2, 4096) : 1024, // an entry per label
        points: points.map(({value, rgb: [r, g, b], opacity}) => ({value, r, g, b, opacity})),
    };
};
const overlayLayer = (level, settings) =>
    ({level, colors: colorsOf(overlayTf(level, settings), level, [level.min, level.max]), cover: settings.cover});

// The level of an overlay with its table for a picture, or null if nothing of it shows.
const shownOverlay = (context, level, settings) => {
    const key = JSON.stringify(settings), {gl} = context;
    if (!level || !settings) return null;
    if (level.tableKey === key) return level.table && level;
    const tf = overlayTf(level, settings), valueRange = [level.min, level.max];
    const covered = {...tf, points: tf.points.map(p => ({...p, opacity: p.opacity * settings.cover}))};
    let table = tabulate(covered, valueRange, Math.cbrt(spacings(level).reduce((a, b) => a * b)));
    if (level.has_no_data) table = endedBelow(table, level.min);
    for (const texture of [level.table?.texture, level.table?.occupancy]) if (texture) gl.deleteTexture(texture);
    const bricks = occupancyOf(level.ranges ??= brickRanges(level.numbers, level.size), level.scalar, table);
    Object.assign(level, {tableKey: key, table: bricks.part > 0 ? {...table, bricks, texture: uploadTable(context, table)} : null});
    return level.table && level;
};
const setOverlay = (program, camera, level, scalar) => {
    const {table} = level, entries = (table.count - 1) / (table.hi - table.lo), range = level.max - level.min;
    program.int('over_scalar', 11);
    program.int('over_tf', 12);
    program.float('over_tf_scale', scalar.perTexel * entries);
    program.float('over_tf_offset', (level.scalar.zero - table.lo) * entries);
    program.int('over_tf_count', table.count);
    program.int('over_labels', level.labels);
    program.int('over_occupancy', 13);
    program.vec3('over_bricks_per_volume', level.size.map(n => n / brickVoxels));
    program.mat3('over_to_index', inverse(level.index_to_world));
    program.vec3('over_position_index', toIndex(level, camera.position));
    program.vec3('over_box_index', level.size);
    const factor = range > 0 ? 0.5 * scalar.perTexel * Math.min(...spacings(level)) / range : 0;
    program.mat3('over_gradient_to_world', transpose(inverse(level.index_to_world)).map(row => scale(row, factor)));
    program.float('over_eps', onTheFlyEps);
};

// A transfer function of the volume, for another one: over the same values, and over the same lengths.
const tfInMm = (data, {unit_distance_voxels: voxels, unit_distance_mm: mm, ...tf}) => ({
    ...tf, range: tfRange(tf, data.value_range), unit_distance_mm: mm ?? voxels * data.mean_spacing_mm,
    points: tf.points.map(p => ({...p, value: valueOf(tf, p, data.value_range)})),
});

// The controls. take(file) opens a file as overlay; renew() makes the controls again.
const overlayPanel = (data, state, take, moved, renew) => {
    const file = element('input', {type: 'file', accept: '.nrrd,.nii,.gz'});
    const over = state.overlay, level = data.overlay?.level;
    file.addEventListener('change', () => take(file.files[0]));
    const chooser = labeled(data.overlay?.name ?? 'second volume', file);
    if (!level || !over) return [chooser];
    const set = (change, isMoving) => {
        state.overlay = {...state.overlay, ...change};
        moved(isMoving);
    };
    const limits = {min: level.min, max: level.max, step: 'any'}, range = () => overlayRange(level, state.overlay);
    const bound = (text, i) => slider(text, {...limits, value: Number(range()[i].toPrecision(6))},
        (v, isMoving) => set({range: i ? [range()[0], v] : [v, range()[1]]}, isMoving));
    const text = over.tf ? 'its own colors' : 'take the transfer function above';
    const own = element('button', {type: 'button', textContent: text});
    own.addEventListener('click', () => { set({tf: over.tf ? null : tfInMm(data, state.tf)}); renew(); });
    return [
        chooser,
        slider('cover', {min: 0, max: 1, step: 0.01, value: over.cover}, (cover, isMoving) => set({cover}, isMoving)),
        ...(over.tf || level.labels ? [] : [bound('clear below', 0), bound('white from', 1)]),
        element('div', {className: 'buttons'}, own),
    ];
};
