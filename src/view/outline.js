// SPDX-License-Identifier: MIT
// outline.js - draws lines over the picture: the edges of the region of interest, the slices' crosshair, a length.
const edgesOfBox = [0, 1, 2].flatMap(axis => [0, 1, 2, 3].map(n => [0, 1].map(end => {
    const corner = [0, 0, 0];
    [corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]] = [end, n % 2, n >> 1];
    return corner;
})));

const makeOutline = (svg, data, state, frames) => {
    // Position of a point in the picture; null behind the camera.
    const projected = (world, camera, aspect) => {
        const {forward, right, up} = axesOf(camera), from = subtract(world, camera.position), depth = dot(from, forward);
        if (!camera.orthographic && depth <= 0) return null;
        const half = camera.half * (camera.orthographic ? 1 : depth);
        return [0.5 + 0.5 * dot(from, right) / (half * aspect), 0.5 - 0.5 * dot(from, up) / half];
    };
    const linesInWorld = () => {
        const g = data.geometry0, inWorld = ends => ends.map(index => toWorld(g, index)), lines = [];
        const inBox = corner => corner.map((end, a) => state.roi.box[end][a] * g.box_index[a]);
        if (state.roi) lines.push(...edgesOfBox.map(ends => inWorld(ends.map(inBox))));
        if (state.measure?.length === 2) lines.push(state.measure);
        if (!state.slices) return lines;
        const cross = toIndex(g, state.cross), at = (axis, x) => cross.map((c, a) => a === axis ? x : c);
        lines.push(...[0, 1, 2].map(axis => inWorld([at(axis, 0), at(axis, g.box_index[axis])])));
        return lines;
    };
    return () => {
        const [width, height] = frames.size(), aspect = width / height, camera = frames.camera(aspect);
        const lines = linesInWorld().map(ends => ends.map(world => projected(world, camera, aspect)));
        svg.toggleAttribute('hidden', !lines.length);
        drawLines(svg, lines.filter(ends => ends.every(Boolean)));
    };
};
