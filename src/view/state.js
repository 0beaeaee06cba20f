// SPDX-License-Identifier: MIT
// state.js - the state of the page, and its files: scene.json and tf.json, for all commands.
const aspectOf = scene => scene.image.width / scene.image.height;
const makeState = data => {
    const scene = data.scene, tf = linearTf(scene.tf);
    return {
        camera: cameraOf(scene, data.geometry0), sceneAspect: aspectOf(scene), tf, tfName: 'scene',
        lights: scene.lights.map(l => ({space: 'world', intensity: 1, ...l})), shading: {specular: 0, power: 20, ...scene.shading},
        background: scene.background || [0, 0, 0], clips: scene.clip_planes || [], step: scene.step_voxels ?? 0.5,
        level: data.levels[0].level, code: data.codes[0] ?? null, adapted: data.adapted,
        slices: false, cross: boxCenter(data.geometry0), colors: Boolean(data.levels[0].labels), neurological: false,
        window: null, // the usual one
        measure: null, // or up to two points in mm
        edited: null, // the transfer function that was edited last
        overlay: data.overlay ? overlaySettings() : null, // the settings of the second volume
        roi: null, compare: 'none', line: 0.5, amplified: 10, b: {level: data.levels[0].level, code: data.codes[0] ?? null, adapted: false},
    };
};

// The request of side A or B for the caster. A level that is not read yet is replaced by the finest one that is.
const requestOf = (data, state, side) => {
    const wanted = side === 'b' ? state.b : state, ready = data.levels.filter(l => l.numbers);
    const level = ready.find(l => l.level === wanted.level) || ready.reduce((best, l) => Math.abs(l.level - wanted.level) < Math.abs(best.level - wanted.level) ? l : best);
    const {tf, lights, shading, background, clips, step, overlay} = state;
    const both = {tf, lights, shading, background, clips, step, overlay};
    const inside = state.roi && ready.find(l => l.level === state.roi.level && !l.share);
    const roi = inside && inside.level < level.level && wanted.code !== null ? {...state.roi, level: inside} : null;
    if (level.isPlan) return {level, code: level.codes[0].name, adapted: false, ...both, roi: null};
    return {level, code: wanted.code, adapted: wanted.adapted && level.level > 0, ...both, roi};
};

const number = x => Number(x.toPrecision(9));
const tfJson = (data, state) => {
    const {comment, ...tf} = state.tf;
    return {...tf, schema: 'isoshade.tf/1', points: tf.points.map(p => ({value: number(p.value), r: number(p.r), g: number(p.g), b: number(p.b), opacity: number(p.opacity)}))};
};
const sceneJson = (data, state, camera, width, height) => ({
    schema: 'isoshade.scene/1', comment: `Saved from the viewer's page of ${data.title}.`, image: {width, height}, camera: cameraJson(camera),
    lights: state.lights.map(l => ({direction: l.direction, space: l.space, intensity: l.intensity})), shading: {...state.shading},
    ...(state.clips.length ? {clip_planes: state.clips} : {}), background: state.background, step_voxels: state.step, tf: tfJson(data, state),
});
const quoted = s => /^[\w.,/:=+-]+$/.test(s) ? s : `'${s.replace(/'/g, "'\\''")}'`;
const commandOf = (data, state) => {
    const {level, code, adapted} = state, words = ['isoshade render', data.input, '--scene', 'scene.json', '--with gl'];
    const end = ' -o picture.png' + (data.overlay && state.overlay ? ' # without the second volume' : '');
    const plan = data.levels.find(l => l.isPlan && l.level === level);
    if (plan) return [...words, `--plan-error ${plan.predicted_rmse ?? 1 / 255} --brick ${plan.brick_voxels} --brick-levels ${plan.level_count}`].join(' ') + end;
    if (level) words.push(`--level ${level}`);
    words.push(code === null ? '--shading-from on-the-fly' : `--code ${code}`);
    if (adapted && level) words.push('--adapt --always');
    if (state.roi && state.roi.level < level && code !== null) {
        const box = state.roi.box.flatMap(corner => corner.map((part, a) => Number((part * data.geometry0.box_index[a]).toPrecision(6))));
        words.push(`--roi ${box.join()}`, ...(state.roi.level ? [`--roi-level ${state.roi.level}`] : []), `--roi-band ${state.roi.band}`);
    }
    return words.join(' ') + end;
};

