// SPDX-License-Identifier: MIT
// vtk.js draws a request. Everything goes through its public interface, and what it does by itself stays as it is: samples
// of an opacity below 0.001 are left out, the ray begins anywhere in its first step and ends at an opacity of 0.99, and colors
// are looked up in a table of 8 bits. "changes" take that away, by shader replacements, which vtk.js offers to whoever wants.
import '@kitware/vtk.js/Rendering/OpenGL/Profiles/Volume.js';
import vtkDataArray from '@kitware/vtk.js/Common/Core/DataArray.js';
import vtkImageData from '@kitware/vtk.js/Common/DataModel/ImageData.js';
import vtkPiecewiseFunction from '@kitware/vtk.js/Common/DataModel/PiecewiseFunction.js';
import vtkPlane from '@kitware/vtk.js/Common/DataModel/Plane.js';
import vtkColorTransferFunction from '@kitware/vtk.js/Rendering/Core/ColorTransferFunction.js';
import vtkRenderer from '@kitware/vtk.js/Rendering/Core/Renderer.js';
import vtkRenderWindow from '@kitware/vtk.js/Rendering/Core/RenderWindow.js';
import vtkRenderWindowInteractor from '@kitware/vtk.js/Rendering/Core/RenderWindowInteractor.js';
import vtkVolume from '@kitware/vtk.js/Rendering/Core/Volume.js';
import vtkVolumeMapper from '@kitware/vtk.js/Rendering/Core/VolumeMapper.js';
import vtkOpenGLRenderWindow from '@kitware/vtk.js/Rendering/OpenGL/RenderWindow.js';
import vtkOpenGLTexture from '@kitware/vtk.js/Rendering/OpenGL/Texture.js';
import {Filter} from '@kitware/vtk.js/Rendering/OpenGL/Texture/Constants.js';

import {floatCanvas, readBack, samplesOf, seedRandom} from './page.js';

let request, stage;
const changed = name => request.changes.includes(name);
const mostEntries = 8192; // of a table, as textures have them

const imageOf = async ({volume, samples}) => {
    const m = volume.index_to_world, column = a => m.map(row => row[a]), lengths = [0, 1, 2].map(a => Math.hypot(...column(a)));
    const image = vtkImageData.newInstance();
    image.setDimensions(...volume.size);
    image.setSpacing(...lengths);
    image.setDirection(...[0, 1, 2].flatMap(a => column(a).map(x => x / lengths[a])));
    image.setOrigin(...m.map(row => row[3] + (row[0] + row[1] + row[2]) / 2)); // the center of the first voxel
    image.getPointData().setScalars(vtkDataArray.newInstance({name: 'value', numberOfComponents: 1, values: await samplesOf(samples)}));
    return image;
};

// vtk.js fills a table of W entries from the first value to the last, and looks up value x at x W instead of at
// x (W - 1) + 1/2. Points that are moved apart by half an entry at both ends are found where they belong.
const tableOf = ({lo, hi, color, extinction_per_mm: extinction}) => {
    const last = extinction.length - 1, parts = Math.max(1, Math.floor((mostEntries - 1) / Math.max(last, 1)));
    const entries = last * parts + 1, points = [];
    const between = (list, at) => { // linear between the entries of the transfer function
        const i = Math.min(Math.floor(at), Math.max(last - 1, 0)), t = at - i, next = Math.min(i + 1, last);
        return Array.isArray(list[i]) ? list[i].map((v, c) => v + t * (list[next][c] - v)) : list[i] + t * (list[next] - list[i]);
    };
    const aside = changed('tables-as-they-are') || entries < 2 ? 0 : (hi - lo) / (entries - 1) / 2;
    for (let i = 0; i < entries; ++i) {
        const t = entries > 1 ? i / (entries - 1) : 0;
        points.push({x: lo - aside + t * (hi - lo + 2 * aside), rgb: between(color, i / parts), extinction: between(extinction, i / parts)});
    }
    return points;
};

const propertyOf = (volume, points, unit) => {
    const opacity = vtkPiecewiseFunction.newInstance(), color = vtkColorTransferFunction.newInstance();
    const middle = {midpoint: 0.5, sharpness: 0};
    opacity.setNodes(points.map(p => ({x: p.x, y: -Math.expm1(-p.extinction * unit), ...middle})));
    color.setNodes(points.map(p => ({x: p.x, r: p.rgb[0], g: p.rgb[1], b: p.rgb[2], ...middle})));
    const property = volume.getProperty();
    property.setRGBTransferFunction(0, color);
    property.setScalarOpacity(0, opacity);
    property.setScalarOpacityUnitDistance(0, unit);
    property.setShade(false);
    request.volume.interpolation === 'nearest' ? property.setInterpolationTypeToNearest() : property.setInterpolationTypeToLinear();
    return color;
};

const planesOf = () => {
    const m = request.volume.index_to_world, [first, last] = request.volume.box_index, planes = [];
    const world = index => m.map(row => row[0] * index[0] + row[1] * index[1] + row[2] * index[2] + row[3]);
    const across = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const column = a => m.map(row => row[a]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const add = (normal, origin) => planes.push(vtkPlane.newInstance({normal, origin}));
    for (let a = 0; a < 3; ++a) { // the box has the outer faces of the voxels already; what overhangs it is cut off
        const n = across(column((a + 1) % 3), column((a + 2) % 3)), s = Math.sign(dot(n, column(a))) / Math.hypot(...n);
        if (first[a] > 0)
            add(n.map(x => x * s), world(first));
        if (last[a] < request.volume.size[a])
            add(n.map(x => -x * s), world(last));
    }
    for (const {normal, offset_mm: offset} of request.clip_planes ?? [])
        add(normal, normal.map(x => x * offset / dot(normal, normal)));
    if (planes.length > 6)
        throw new Error(`vtk.js has six clip planes, and ${planes.length} are needed`);
    return planes;
};

// Each takes away one thing that vtk.js does in its shaders: of which, what stands there, what shall.
const shaderChanges = {
    // Samples of an opacity below 0.001 are left out, however many they are.
    'no-threshold': [['Fragment', 'if (alpha < EPSILON) {', 'if (alpha < 0.0) {']],
    // The reference's samples: whole steps from the eye, cut off by the box, each by the value in its middle.
    'midpoints': [
        ['Fragment', 'float jitter = 0.01 + 0.99 * fragmentSeed;',
            'float jitter = 1.0 - fract(((cameraParallel == 1 ? -rayOriginVC.z : length(rayOriginVC)) + minDistance) / sampleDistance);'],
        ['Fragment', 'getColorAtPos(firstPosVC)', 'getColorAtPos(firstPosVC + 0.5 * min(jitter, raySteps) * stepVC)'],
        ['Fragment', 'getColorAtPos(posVC)', 'getColorAtPos(posVC + 0.5 * stepVC)'],
        ['Fragment', 'getColorAtPos(endPosVC)', 'getColorAtPos(endPosVC - 0.5 * (raySteps - stepsTraveled) * stepVC)'],
    ],
    // What is transparent is divided by an opacity of zero, which only a canvas of integers forgives.
    'float-canvas': [['Fragment', 'vec4(color.rgb / color.a, color.a)', 'vec4(color.rgb / max(color.a, 1e-30), color.a)']],
    'no-early-end': [['Fragment', 'color.a > 0.99', 'color.a > 0.9999999'], ['Fragment', 'color.a < 0.99 ', 'color.a < 1.0 ']],
    'whole-canvas': ['x', 'y'].map(a => ['Vertex', `dc${a}min + 0.5 * (vertexDC.${a} + 1.0) * (dc${a}max - dc${a}min)`, `vertexDC.${a}`]),
};

const lookFrom = (camera, {projection, position, forward, up, half_height: half, near, far}) => {
    camera.setPosition(...position);
    camera.setFocalPoint(...position.map((p, i) => p + forward[i]));
    camera.setViewUp(...up);
    camera.setParallelProjection(projection === 'orthographic');
    projection === 'orthographic' ? camera.setParallelScale(half) : camera.setViewAngle(2 * Math.atan(half) * 180 / Math.PI);
    camera.setClippingRange(near, far);
};

window.prepare = async asked => {
    request = asked;
    const {width, height} = request.image, renderer = vtkRenderer.newInstance();
    const window = vtkRenderWindow.newInstance(), view = vtkOpenGLRenderWindow.newInstance();
    const canvas = document.createElement('canvas');
    // Samples of the pixel's edges belong to no ray: one sample, at its center.
    canvas.getContext('webgl2', {antialias: changed('antialias'), depth: true, alpha: true, preserveDrawingBuffer: false});
    document.body.append(canvas);
    renderer.setBackground(...request.background, 0); // blended colors get the background, blended opacities do not
    view.setCanvas(canvas);
    view.setSize(width, height);
    window.addRenderer(renderer);
    window.addView(view);
    const interactor = vtkRenderWindowInteractor.newInstance();
    interactor.setView(view);
    interactor.initialize();
    const mapper = vtkVolumeMapper.newInstance(), volume = vtkVolume.newInstance(), points = tableOf(request.tf);
    mapper.setInputData(await imageOf(request));
    planesOf().forEach(p => mapper.addClippingPlane(p));
    volume.setMapper(mapper);
    if (!changed('tables-as-they-are')) {
        mapper.setOpacityTextureWidth(points.length);
        mapper.setColorTextureWidth(points.length);
    }
    mapper.getViewSpecificProperties().OpenGL = {
        ShaderReplacements: request.changes.flatMap(name => shaderChanges[name] ?? []).map(([shaderType, from, to]) => (
            {shaderType, replaceFirst: true, originalValue: from, replacementValue: to, replaceAll: false})),
    };
    renderer.addVolume(volume);
    lookFrom(renderer.getActiveCamera(), request.camera);
    stage = {window, view, canvas, mapper, volume, points};
    const gl = canvas.getContext('webgl2');
    if (changed('float-canvas'))
        floatCanvas(gl, width, height);
};

// In the place of the library's own table of 8 bits, under the same name.
const floatColors = color => {
    const {view, points} = stage, row = points.flatMap(p => p.rgb), {hash} = view.getGraphicsResourceForObject(color);
    const texture = vtkOpenGLTexture.newInstance({minificationFilter: Filter.LINEAR, magnificationFilter: Filter.LINEAR});
    texture.setOpenGLRenderWindow(view);
    texture.create2DFromRaw({width: points.length, height: 2, numComps: 3, dataType: 'Float32Array', data: Float32Array.from([...row, ...row])});
    view.setGraphicsResourceForObject(color, texture, hash);
    stage.volume.modified(); // looks its textures up again
};

window.draw = async frame => {
    const {window, canvas, mapper, volume, points} = stage, {width, height} = request.image;
    seedRandom(frame.seed ?? 0);
    // A distance in which the densest value is not opaque, so that its opacity keeps its digits.
    const most = Math.max(...points.map(p => p.extinction)), unit = most > 0 ? 1 / most : 1;
    const color = propertyOf(volume, points, unit);
    mapper.setSampleDistance(frame.step_mm);
    mapper.setMaximumSamplesPerRay(1000000);
    mapper.setAutoAdjustSampleDistances(false);
    window.render();
    if (changed('float-colors')) {
        floatColors(color);
        window.render();
    }
    const gl = canvas.getContext('webgl2'), error = gl.getError();
    if (error)
        throw new Error(`OpenGL says ${error}`);
    return readBack(gl, width, height, changed('float-canvas'));
};
