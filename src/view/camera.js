// SPDX-License-Identifier: MIT
// camera.js - the camera of a scene file, with the terms of scene.c: fitting and moving it.
// 
// A camera is {orthographic, position, lookAt, up, half}: half the height of the picture, as a tangent or in mm.
const cameraOf = (scene, g) => {
    const c = scene.camera, orthographic = c.projection === 'orthographic', up = c.up || [0, 0, 1];
    const halfAngle = 0.5 * (c.fov_y_deg ?? 30) * Math.PI / 180, {width, height} = scene.image || {width: 160, height: 160};
    let half = orthographic ? 0.5 * c.height_mm : Math.tan(halfAngle), position = c.position, lookAt = c.look_at;
    if (c.fit) {
        const radius = (c.margin ?? 1.05) * boxRadius(g) / Math.min(1, width / height);
        lookAt = boxCenter(g);
        position = madd(lookAt, normalize(c.direction), -(orthographic ? 2 * radius : radius / Math.sin(halfAngle)));
        if (orthographic) half = radius;
    }
    if (c.zoom > 0) half /= c.zoom;
    const forward = normalize(subtract(lookAt, position));
    // It orbits about the middle of the volume if it looks past that.
    const depth = dot(subtract(boxCenter(g), position), forward);
    if (depth > 0) lookAt = madd(position, forward, depth);
    return {orthographic, position, lookAt, up, half};
};
const axesOf = c => {
    const forward = normalize(subtract(c.lookAt, c.position)), right = normalize(cross(forward, c.up));
    return {forward, right, up: cross(right, forward)};
};
// Adapts to a picture of another shape than the scene's, without cutting off its sides.
const widened = (c, sceneAspect, aspect) => ({...c, half: c.half * Math.max(1, sceneAspect / aspect)});

const orbited = (c, dx, dy) => {
    const {right, up} = axesOf(c), turn = v => rotate(rotate(v, up, -dx), right, -dy);
    return {...c, position: add(c.lookAt, turn(subtract(c.position, c.lookAt))), up: normalize(turn(up))};
};
const rolled = (c, angle) => ({...c, up: rotate(axesOf(c).up, axesOf(c).forward, angle)});
// In parts of the picture's height.
const panned = (c, dx, dy) => {
    const {forward, right, up} = axesOf(c), depth = c.orthographic ? 1 : dot(subtract(c.lookAt, c.position), forward);
    const move = add(scale(right, -2 * dx * c.half * depth), scale(up, 2 * dy * c.half * depth));
    return {...c, position: add(c.position, move), lookAt: add(c.lookAt, move)};
};
const leastMm = 1e-30, mostMm = 1e30; // ISO_LEAST_MM, ISO_MOST_MM: scene files allow no other heights
const zoomed = (c, factor) => ({...c, half: clamp(c.half / factor, c.orthographic ? leastMm : 1e-6, c.orthographic ? mostMm : 20)});
const lookingFrom = (c, g, direction, up, sceneAspect) => {
    const lookAt = boxCenter(g), radius = 1.05 * boxRadius(g) / Math.min(1, sceneAspect);
    const half = c.orthographic ? radius : c.half, distance = c.orthographic ? 2 * radius : radius / Math.sin(Math.atan(half));
    return {...c, lookAt, up, half, position: madd(lookAt, normalize(direction), -distance)};
};

// A scene file's angle is 0.01 to 175 degrees; a smaller one becomes a zoom.
const angleJson = half => {
    const least = 0.01, degrees = 2 * Math.atan(half) * 180 / Math.PI;
    return degrees < least ? {fov_y_deg: least, zoom: Math.tan(least * Math.PI / 360) / half} : {fov_y_deg: Math.min(degrees, 175)};
};
// The camera for a scene file, with all digits of a double.
const cameraJson = c => ({
    projection: c.orthographic ? 'orthographic' : 'perspective', position: c.position, look_at: c.lookAt, up: c.up,
    ...(c.orthographic ? {height_mm: 2 * c.half} : angleJson(c.half)),
});
const viewpoints = [
    ['iso', [0.6, -1, -0.45], [0, 0, 1]], ['front', [0, -1, 0], [0, 0, 1]], ['back', [0, 1, 0], [0, 0, 1]],
    ['left', [1, 0, 0], [0, 0, 1]], ['right', [-1, 0, 0], [0, 0, 1]], ['top', [0, 0, -1], [0, 1, 0]], ['bottom', [0, 0, 1], [0, 1, 0]],
];

// Clip planes in the index coordinates of a level: xyz . index >= w is kept.
const clipInIndex = (plane, g0, g) => {
    const n = normalize(plane.normal);
    let offset;
    if (plane.point_mm) {
        offset = dot(n, plane.point_mm);
    } else {
        let extent = 0;
        for (let a = 0; a < 3; ++a) extent += Math.abs(dot(n, column(g0.index_to_world, a))) * g0.box_index[a];
        offset = dot(n, boxCenter(g0)) + (plane.at - 0.5) * extent;
    }
    return [...[0, 1, 2].map(a => dot(n, column(g.index_to_world, a))), offset - dot(n, g.origin_mm)];
};
const lightInWorld = (light, axes) => {
    const d = normalize(light.direction);
    return light.space === 'camera' ? madd(madd(scale(axes.right, d[0]), axes.up, d[1]), axes.forward, -d[2]) : d;
};
