// SPDX-License-Identifier: MIT
// first_hit.glsl - the first point of the ray inside the box where the value is at least iso: opaque, c(iso) shade(d).
//
// The reference's definition (first_hit in reference.c): between two planes of samples the value is a cubic of the ray's
// length, known from four fetches; its Bezier points bound it, and other intervals are halved. So no step is
// too long for a thin sheet.
//
// OUTPUT_HIT_COLOR, or the place in index coordinates (OUTPUT_HIT_PLACE) or the shading normal (OUTPUT_HIT_NORMAL), whose
// alpha is 0 without a hit. Otherwise as in raycast.glsl.

uniform float iso_texel;     // the surface's value, as a texel
uniform vec3 samples_per_p;  // of level 0; brick levels are coarser by their layout's w
uniform float first_sample;  // planes of samples are where samples_per_p * p - first_sample is whole

// A cell among samples: of one brick, so that its four values are of one function.
struct Cell {
    vec3 brick;
    vec3 scale; // samples in p
};

Cell cell_at(vec3 p)
{
#if BRICKS
    vec3 brick = brick_of(p);
    float w = layout_of(brick).w;
    return Cell(brick, samples_per_p * (w > 0.0 ? w : 1.0));
#else
    return Cell(vec3(0.0), samples_per_p);
#endif
}

// Omitted voxels are below every surface.
float value_in(Cell cell, vec3 p)
{
#if BRICKS
    vec4 where = address_in(cell.brick, p);
    return where.w > 0.0 ? scalar_at(where.xyz) : -1e30;
#else
    return scalar_at(p);
#endif
}

// Segments until a point that moves by `stride` a segment passes one of two planes an axis.
float steps_to(vec3 p, vec3 stride, vec3 low, vec3 high)
{
    vec3 face = mix(low, high, greaterThan(stride, vec3(0.0)));
    vec3 steps = (face - p) / mix(stride, vec3(1e-30), equal(stride, vec3(0.0)));
    steps = mix(steps, vec3(1e30), equal(stride, vec3(0.0)));
    return max(min(steps.x, min(steps.y, steps.z)), 0.0);
}

// Where the cell that begins at `at` ends. Slivers of rounding at its planes are passed over.
const float sliver = 1e-4;

float cell_end(Ray ray, Cell cell, float at, float last)
{
    vec3 q = point_of(ray, at + sliver) * cell.scale - first_sample, low = floor(q), high = low + 1.0;
#if BRICKS
    // The volume may end inside a cell: from its last node on the value is kept.
    vec3 end = held.last_node * cell.scale;
    low = mix(low, max(low, end), greaterThanEqual(q, end));
    high = mix(min(high, end), high, greaterThanEqual(q, end));
#endif
    return min(at + sliver + steps_to(q, ray.stride * cell.scale, low, high), last);
}

#if SKIP_EMPTY
// As leave_empty_bricks, to the face itself.
float leave_empty(Ray ray, float at, float last)
{
    while (at < last) {
        vec3 p = point_of(ray, at + sliver) * held.bricks_per_volume;
        ivec3 brick = clamp(ivec3(p), ivec3(0), held.last_occupancy);
        int empty = int(texelFetch(occupancy, brick, 0).r);
        if (empty == 0)
            break;
        at += sliver + steps_to(p, ray.stride * held.bricks_per_volume, vec3(brick + 1 - empty), vec3(brick + empty));
    }
    return at;
}
#endif

// The cubic through the values at 0, 1/3, 2/3 and 1, as powers.
vec4 cubic_through(float s[4])
{
    return vec4(s[0], 0.5 * (-11.0 * s[0] + 18.0 * s[1] - 9.0 * s[2] + 2.0 * s[3]),
                0.5 * (18.0 * s[0] - 45.0 * s[1] + 36.0 * s[2] - 9.0 * s[3]),
                0.5 * (-9.0 * s[0] + 27.0 * s[1] - 27.0 * s[2] + 9.0 * s[3]));
}

// Bezier points of the cubic c on [u, u + w].
vec4 bezier(vec4 c, float u, float w)
{
    float value = c.x + u * (c.y + u * (c.z + u * c.w));
    float first = w * (c.y + u * (2.0 * c.z + 3.0 * u * c.w)) / 3.0;
    float second = w * w * (c.z + 3.0 * u * c.w) / 3.0;
    return vec4(value, value + first, value + 2.0 * first + second,
                value + 3.0 * (first + second) + w * w * w * c.w);
}

// The first u in [0, 1] where the cubic is at least iso, or 2.
float first_root(vec4 c, float iso)
{
    float u = 0.0, w = 1.0;
    while (u < 1.0) {
        vec4 b = bezier(c, u, w);
        if (b.x >= iso)
            return u;
        if (max(b.y, max(b.z, b.w)) < iso) {
            u += w;
            w = min(2.0 * w, 1.0 - u);
        } else if (w < 1e-6) {
            u += w;
        } else {
            w *= 0.5;
        }
    }
    return 2.0;
}

// Segment in which the ray first hits; beyond its end if it does not.
float hit(Ray ray)
{
    float at = ray.first_cut - 0.5, last = ray.length - 0.5, nowhere = last + 1.0;
    // As in raycast.glsl: the search is a loop, rarely executed code stands outside it.
    while (at < last) {
        float end = at, s[4] = float[4](0.0, 0.0, 0.0, 0.0);
        vec4 cubic = vec4(0.0);
        bool found = false;
        for (; at < last; at = end) {
#if SKIP_EMPTY
            at = leave_empty(ray, at, last);
            if (at >= last)
                break;
#endif
            Cell cell = cell_at(point_of(ray, at + sliver));
            end = cell_end(ray, cell, at, last);
            for (int i = 0; i < 4; ++i)
                s[i] = value_in(cell, point_of(ray, at + (end - at) * float(i) / 3.0));
            cubic = cubic_through(s);
            vec4 b = bezier(cubic, 0.0, 1.0);
            found = max(max(b.x, b.y), max(b.z, b.w)) >= iso_texel;
            if (found)
                break;
        }
        if (!found)
            break;
        float u = first_root(cubic, iso_texel);
        if (u <= 1.0)
            return at + u * (end - at);
        at = end;
    }
    return nowhere;
}

void main()
{
    hold_uniforms();
    Ray ray = pixel_ray();
    float at = hit(ray);
    bool found = at < ray.length;
    vec3 p = point_of(ray, at);
    vec4 where = address(p);
#if OUTPUT == OUTPUT_HIT_COLOR
    color = vec4(background, 0.0);
    if (found)
        color = vec4(tf_row(iso_texel, 0).rgb * shade_at(where.xyz, halfway_to(ray.world)), 1.0);
#elif OUTPUT == OUTPUT_HIT_PLACE
    color = found ? vec4(p * samples_per_p - first_sample + 0.5, 1.0) : vec4(0.0);
#else
    color = found ? vec4(normal_at(where.xyz), 1.0) : vec4(0.0);
#endif
}
