// SPDX-License-Identifier: MIT
// outline.js - draws the edges of the region of interest over the picture: lines from 0 to 1 to the right and
// downwards.
const edgesOfBox = [0, 1, 2].flatMap(axis => [0, 1, 2, 3].map(n => [0, 1].map(end => {
    const corner = [0, 0, 0];
    [corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]] = [end, n % 2, n >> 1];
    return corner;
})));

const makeOutline = (svg, data, state, frames) => {
    const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
    svg.replaceChildren(path);
    // Position of a point in the picture; null behind the camera.
    const projected = (world, camera, aspect) => {
        const {forward, right, up} = axesOf(camera), from = subtract(world, camera.position), depth = dot(from, forward);
        if (!camera.orthographic && depth <= 0) return null;
        const half = camera.half * (camera.orthographic ? 1 : depth);
        return [0.5 + 0.5 * dot(from, right) / (half * aspect), 0.5 - 0.5 * dot(from, up) / half];
    };
    return () => {
        svg.toggleAttribute('hidden', !state.roi);
        if (!state.roi) return;
        const [width, height] = frames.size(), aspect = width / height, camera = frames.camera(aspect), g = data.geometry0;
        const place = corner => projected(toWorld(g, corner.map((end, a) => state.roi.box[end][a] * g.box_index[a])), camera, aspect);
        const lines = edgesOfBox.map(ends => ends.map(place)).filter(ends => ends.every(Boolean));
        path.setAttribute('d', lines.map(ends => `M${ends.map(p => p.map(x => x.toFixed(5)).join(' ')).join('L')}`).join(''));
    };
};
