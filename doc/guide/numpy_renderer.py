# numpy_renderer.py - a ray caster in numpy, started by isoshade with the path of a request
import json, sys
import numpy as np

def read_nrrd(about, size):  # as isoshade writes them: raw floats after an empty line, x fastest
    with open(about['file'], 'rb') as f:
        return np.frombuffer(f.read().split(b'\n\n', 1)[1], '<f4').reshape(*size[::-1], -1).astype(float)

def look_up(grid, p):  # trilinear between the centers of voxels, clamped to the edge
    last = np.array(grid.shape[2::-1]) - 1
    q = np.clip(p - 0.5, 0, last)
    low, value = np.minimum(q.astype(int), np.maximum(last - 1, 0)), 0
    for corner in np.ndindex(2, 2, 2):
        x, y, z = np.minimum(low + corner, last).T
        value = value + np.where(corner, q - low, 1 - (q - low)).prod(1)[:, None] * grid[z, y, x]
    return value

def shade(r, d, to_viewer):  # both sides of a surface are lit
    s, n = r['shading'], d / np.sqrt((d * d).sum(1) + r['directions']['epsilon'] ** 2)[:, None]
    light = np.full(len(n), s['ambient'])
    for l in r['lights']:
        half = l['direction'] + to_viewer
        highlight = np.abs((n * half).sum(1) / np.linalg.norm(half, axis=1)) ** s['power']
        light += l['intensity'] * (s['diffuse'] * np.abs(n @ l['direction']) + s['specular'] * highlight)
    return light

def render(r, grid, step):  # samples in the middle of the segments [k step, (k + 1) step] of each ray
    c, v, tf, w, h = r['camera'], r['volume'], r['tf'], r['image']['width'], r['image']['height']
    x, y = (2 * np.arange(w) + 1 - w) / h * c['half_height'], (h - 1 - 2 * np.arange(h)) / h * c['half_height']
    offset = (x[None, :, None] * np.array(c['right']) + y[:, None, None] * np.array(c['up'])).reshape(-1, 3)
    parallel = c['projection'] == 'orthographic'
    origin, ray = c['position'] + offset * parallel, c['forward'] + offset * (not parallel)
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    m = np.linalg.inv(np.vstack((v['index_to_world'], (0, 0, 0, 1))))
    p, d = origin @ m[:3, :3].T + m[:3, 3], ray @ m[:3, :3].T  # the ray in index coordinates
    faces = (np.array(v['box_index'])[:, None] - p) / np.where(d == 0, 1e-300, d)
    t0, t1 = np.maximum(faces.min(0).max(1), 0), faces.max(0).min(1)
    for plane in r['clip_planes']:  # what lies on the normal's side stays
        toward = ray @ plane['normal']
        cut = (plane['offset_mm'] - origin @ plane['normal']) / np.where(toward == 0, 1e-300, toward)
        t0, t1 = np.where(toward >= 0, np.maximum(t0, cut), t0), np.where(toward >= 0, t1, np.minimum(t1, cut))
    table, at = np.column_stack((tf['color'], tf['extinction_per_mm'])), np.linspace(tf['lo'], tf['hi'], len(tf['color']))
    rgba, through, k = np.zeros((w * h, 4)), np.ones(w * h), np.floor(t0 / step)
    while (k * step < t1).any():
        a, b = np.maximum(k * step, t0), np.minimum((k + 1) * step, t1)
        i, k = np.flatnonzero(b > a), k + 1
        field = look_up(grid, p[i] + ((a + b) / 2)[i, None] * d[i])
        red, green, blue, sigma = (np.interp(field[:, 0], at, column) for column in table.T)
        alpha = -np.expm1(-sigma * (b - a)[i])
        light = shade(r, field[:, 1:], -ray[i]) if r['directions'] else r['shading']['ambient']
        rgba[i] += (through[i] * alpha * (red * light, green * light, blue * light, np.ones(len(i)))).T
        through[i] *= 1 - alpha
    rgba[:, :3] += through[:, None] * r['background']
    return rgba.reshape(h, w, 4)

if __name__ == '__main__':
    r = json.load(open(sys.argv[1]))
    grids = [read_nrrd(about, r['volume']['size']) for about in (r['volume'], r['directions']) if about]
    for frame in r['frames']:
        picture = render(r, np.concatenate(grids, 3), frame['step_mm'])
        np.save(frame['file'].replace('.exr', '.npy'), picture.astype('f4'))
