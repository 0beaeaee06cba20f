// SPDX-License-Identifier: MIT
// raycast.glsl - the rendering equation by midpoint segments, one ray a pixel.
//
// Positions p are texture coordinates of the volume; with BRICKS they are bricks: brick floor(p), fract(p) in it.
//
// A ray is set up in double precision, once a pixel: where a thin shell is met at a glancing angle, 1e-5 voxels of shift
// show in the image. Its samples are floats, from the middle of the first segment.
//
// Defined before this file (gl_variant.c), each 0 or 1 unless noted:
//     DIRECTION_SOURCE, OUTPUT   names of variants.h
//     DECODER                    a name of code_decode.h, for SOURCE_CODES
//     SCALAR_WITH_DIRECTIONS     the scalar is the alpha of the directions, so that a sample's fetch is that of its normal
//     LIGHT_COUNT, SPECULAR      of the view
//     SHADE_TABLE                a palette's shades instead of its directions
//     SKIP_EMPTY                 bricks that the TF does not show are passed over
//     SCREEN_TILE                with SKIP_EMPTY: edge in pixels of tiles with a visible range, or 0
//     PREINTEGRATED              the TF's means between the values at both ends of a segment
//     EXACT                      textures are filtered here and values classified, in double
//     ROI                        a finer level inside a region: roi.glsl
//     TF_2D_ROWS                 rows of a 2D transfer function (tf_2d.h); 0: it is 1D
//     EXTINCTION_SCALE           where its bytes are, a name of variants.h
//     BRICKS, PAGES              a cache of bricks, and how many textures hold it
//     TRANSITION                 with BRICKS whose samples lie inside them (isoshade-lab); otherwise undefined
//     FILTERED_BY_HAND           textures are filtered here, in float: where the texture unit weighs texels coarsely, or does
//                                not filter floats (WebGL2 on some telephones); otherwise undefined
//     OVERLAY                    a second volume: view/overlay.glsl follows this file; otherwise undefined
// In WebGL2 es.glsl stands before this file: doubles are floats there, and the rests that they leave are 0.
#include "variants.h"

uniform dvec2 image_size, first_pixel; // first_pixel: where the target's is in the picture
uniform bool orthographic;
uniform dvec2 half_image;          // tan of the half angles, or mm when orthographic
uniform dvec3 forward, right, up;  // of the camera, world
uniform dmat3 to_index;            // index steps of one mm along x, y, z
uniform dvec3 position_index;      // of the camera
uniform dvec3 box_index;           // the box is [0, box_index]
uniform double step_mm;
uniform dvec3 index_scale, index_offset; // p = scale * index + offset
uniform int clip_count;
uniform dvec4 clip_planes[6];      // index positions with xyz . index >= w stay: ISO_MAX_CLIP_PLANES

uniform sampler3D scalar;
uniform sampler2D tf;
uniform float tf_scale, tf_offset; // texel value to entry
uniform int tf_count;

#if TF_2D_ROWS
uniform sampler3D second_value;      // 0 in the first row, 1 in the last
#endif

#if EXTINCTION_SCALE == SCALE_ALONE
uniform sampler3D extinction_scale;
#endif
uniform float octaves_per_texel, octaves_offset; // texel value to log2 of the scale

#if PREINTEGRATED
uniform sampler2D tf_sums;         // rows: of sigma c and sigma up to each entry, and what float leaves of them
#endif

#if SKIP_EMPTY
uniform usampler3D occupancy;      // distance of each brick to the nearest one that the TF shows
uniform vec3 bricks_per_volume;    // p to bricks
#if SCREEN_TILE
uniform sampler2D reach;           // a tile's rays show nothing nearer than r and farther than g, in mm
#endif
#endif

#if BRICKS
uniform sampler3D layout_of_bricks; // xyz: where the brick's node (0,0,0) is in the cache; w: 2^-level, 0: left out
uniform vec3 brick_in_cache;        // a brick of level 0, in texture coordinates of the cache
uniform vec3 last_node;             // p of the volume's last node
#endif
#if PAGES > 1                       // of the cache: coordinates z + page
uniform sampler3D scalar_pages[PAGES - 1], direction_pages[PAGES - 1]; // those after the first
#endif

#if DIRECTION_SOURCE == SOURCE_PALETTE || DIRECTION_SOURCE == SOURCE_NEAREST
uniform usampler3D palette_index;
uniform sampler2D palette;        // an entry: its direction, and its shade under the lights
#endif

uniform sampler3D directions;
uniform float direction_scale, direction_offset; // texel value to lattice vector
uniform vec3 voxel;               // one voxel in texture coordinates
uniform mat3 gradient_to_world;   // of texel differences, made unitless: set_field in raycaster.c
uniform float on_the_fly_eps;

uniform vec3 light_direction[LIGHT_COUNT + 1];
uniform float light_intensity[LIGHT_COUNT + 1];
uniform vec4 shading;             // ambient, diffuse, specular, power
uniform vec3 background;
out vec4 color;

#include "held.glsl"

#if EXACT
dvec3 exact_start, exact_stride; // of the ray
dvec3 exact_p;                   // of the segment at hand
vec3 rounded_p;                  // what stands for it everywhere else
#endif

struct Ray {
    vec3 start, stride; // p in the first segment's middle; a segment further
    vec3 start_rest, stride_rest; // what float leaves of them: a hundred segments on it would be 1e-5 voxels
    float first_cut;    // part of the first segment that the box cuts off, in segments
    float number;       // of the first segment, counted from the camera
    float length;       // segments to the end of the box, counted from where the first one begins
    float from, to;     // the range that can show anything, in segments
    vec3 world;         // unit direction
};

// A straight line through a grid.
struct Line {
    dvec3 origin, direction; // in voxels, and per mm
    dvec3 world;             // unit direction
};

Line pixel_line(dmat3 to_index, dvec3 position_index)
{
    // Row 0 is the top of the image and the first row of the target.
    dvec2 twice = 2.0 * (dvec2(gl_FragCoord.xy) + first_pixel);
    dvec2 p = (twice - image_size) / image_size * dvec2(half_image.x, -half_image.y);
    dvec3 offset = p.x * right + p.y * up;
    dvec3 world = orthographic ? forward : (forward + offset) / sqrt(1.0 + dot(p, p));
    return Line(orthographic ? position_index + to_index * offset : position_index, to_index * world, world);
}

// The part of a line that lies in a box [0, box_index] in front of the camera, in mm from the camera.
dvec2 part_inside(Line line, dvec3 box_index)
{
    dvec3 least = dvec3(1e-20 / step_mm); // of a voxel, in a step: any unit of length has it
    dvec3 safe = mix(line.direction, least, lessThan(abs(line.direction), least));
    dvec3 a = -line.origin / safe, b = (box_index - line.origin) / safe, near = min(a, b), far = max(a, b);
    return dvec2(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), far.z));
}

// The part that the clip planes leave.
dvec2 part_kept(Line line, dvec2 part)
{
    for (int i = 0; i < clip_count; ++i) {
        double above = dot(clip_planes[i].xyz, line.origin) - clip_planes[i].w;
        double rate = dot(clip_planes[i].xyz, line.direction);
        if (rate > 0.0)
            part.x = max(part.x, -above / rate);
        else if (rate < 0.0)
            part.y = min(part.y, -above / rate);
        else if (above < 0.0)
            part.y = part.x;
    }
    return part;
}

Ray ray_along(Line line, dvec2 part, dvec3 index_scale, dvec3 index_offset)
{
    double t0 = part.x, t1 = part.y, first = floor(t0 / step_mm);
    Ray ray;
    dvec3 start = (line.origin + (first + 0.5) * step_mm * line.direction) * index_scale + index_offset;
    dvec3 stride = step_mm * line.direction * index_scale;
    ray.number = float(first);
    ray.start = vec3(start);
    ray.stride = vec3(stride);
    ray.start_rest = vec3(start - dvec3(ray.start));
    ray.stride_rest = vec3(stride - dvec3(ray.stride));
#if EXACT
    exact_start = start;
    exact_stride = stride;
#endif
    ray.first_cut = float(t0 / step_mm - first);
    ray.length = t1 > t0 ? float(t1 / step_mm - first) : 0.0;
    ray.from = 0.0;
    ray.to = ray.length;
#if SKIP_EMPTY && SCREEN_TILE
    dvec2 shown = floor(dvec2(texelFetch(reach, ivec2(gl_FragCoord.xy) / SCREEN_TILE, 0).rg) / step_mm) - first;
    ray.from = max(float(shown.x), 0.0);
    ray.to = min(float(shown.y) + 1.0, ray.length);
#endif
    ray.world = vec3(line.world);
    return ray;
}

Ray pixel_ray()
{
    Line line = pixel_line(to_index, position_index);
    return ray_along(line, part_kept(line, part_inside(line, box_index)), index_scale, index_offset);
}

struct Segment {
    vec3 p;     // the middle
    float part; // of a whole segment; exactly 1 away from the ends
#if PREINTEGRATED
    vec3 front, back; // its ends
#endif
};

// p, `at` segments on from the first one's middle.
vec3 point_of(Ray ray, float at)
{
    return fma(vec3(at), ray.stride, ray.start) + (ray.start_rest + at * ray.stride_rest);
}

Segment segment(Ray ray, float k)
{
    float front = k == 0.0 ? ray.first_cut : 0.0, back = max(k + 1.0 - ray.length, 0.0);
    Segment s;
    s.p = point_of(ray, k + 0.5 * (front - back));
    s.part = 1.0 - front - back;
#if EXACT
    exact_p = exact_start + (double(k) + 0.5 * (double(front) - double(back))) * exact_stride;
    rounded_p = s.p;
#endif
#if PREINTEGRATED
    s.front = point_of(ray, k - 0.5 + front);
    s.back = point_of(ray, k + 0.5 - back);
#endif
    return s;
}

#if SKIP_EMPTY
// True if the brick of segment k's middle is empty by `bricks`, the distances to bricks that are not. `end` is the first
// segment beyond the brick, or beyond the cube of bricks nearer than `distance`, all empty. Brick ranges reach half a
// voxel further than the brick, so rounding at its faces does not matter.
bool is_empty(usampler3D bricks, vec3 per_volume, ivec3 last, Ray ray, float k, out float end)
{
    vec3 p = segment(ray, k).p * per_volume;
    ivec3 brick = clamp(ivec3(p), ivec3(0), last);
    int empty = int(texelFetch(bricks, brick, 0).r), reach = max(empty, 1);
    vec3 stride = ray.stride * per_volume;
    vec3 face = vec3(brick) + mix(vec3(1 - reach), vec3(reach), greaterThan(stride, vec3(0.0)));
    vec3 steps = (face - p) / mix(stride, vec3(1e-30), equal(stride, vec3(0.0)));
    steps = mix(steps, vec3(1e30), equal(stride, vec3(0.0)));
    end = k + floor(max(min(steps.x, min(steps.y, steps.z)), 0.0)) + 1.0;
    return empty > 0;
}

// True if segment k lies in a visible brick; segments before `until` are known to. If not, k becomes the first segment
// that may.
bool leave_empty_bricks(Ray ray, inout float k, inout float until)
{
    bool known = k < until;
    if (!known) {
        float end;
        known = !is_empty(occupancy, held.bricks_per_volume, held.last_occupancy, ray, k, end);
        if (known)
            until = end;
        else
            k = end;
    }
    return known;
}
#endif

#if EXACT || defined FILTERED_BY_HAND
uniform bool labels; // are not filtered: the voxel that holds the position
#endif

// The texture's value at p: eight texels, weighted.
#ifdef FILTERED_BY_HAND
vec4 filtered(sampler3D texels, vec3 p)
{
    ivec3 last = textureSize(texels, 0) - 1;
    vec3 q = clamp(p * vec3(last + 1) - 0.5, vec3(0.0), vec3(last)), lo = floor(q);
    vec4 sum = vec4(0.0);
    for (int c = 0; c < 8; ++c) {
        ivec3 corner = ivec3(c & 1, c >> 1 & 1, c >> 2);
        vec3 w = mix(1.0 - (q - lo), q - lo, vec3(corner));
        sum += w.x * w.y * w.z * texelFetch(texels, min(ivec3(lo) + corner, last), 0);
    }
    return sum;
}
#else
vec4 filtered(sampler3D texels, vec3 p) { return textureLod(texels, p, 0.0); }
#endif

#if BRICKS
// Whole numbers.
vec3 brick_of(vec3 p) { return min(floor(clamp(p, vec3(0.0), held.last_node)), held.last_brick); }

// Of a texture without filter: in software OpenGL a texelFetch() finds sizes and strides lane by lane.
vec4 layout_of(vec3 brick) { return textureLod(layout_of_bricks, (brick + 0.5) * held.layout_texel, 0.0); }

#ifdef TRANSITION
#include "transition.h"
#else
// Place of p in the cache for a brick whose closed box holds p; w is 0 if it is left out.
vec4 address_in(vec3 brick, vec3 p)
{
    vec4 place = layout_of(brick);
    vec3 in_brick = clamp(clamp(p, vec3(0.0), held.last_node) - brick, 0.0, 1.0);
    return vec4(place.xyz + in_brick * place.w * held.brick_in_cache, place.w);
}
#endif
#endif

// Place of p in the textures; w is 0 if it is not there.
vec4 address(vec3 p)
{
#if BRICKS
    return address_in(brick_of(p), p);
#else
    return vec4(p, 1.0);
#endif
}

#if EXACT
// The filter's eight texels, weighted for the position that is meant. A texture coordinate is a float, which is up to 3e-8
// of the whole volume off: where a steep TF meets a steep value, that shows in the fifth digit of the image.
dvec4 fetch_exactly(sampler3D texels, vec3 p)
{
    ivec3 last = textureSize(texels, 0) - 1;
    dvec3 q = clamp((exact_p + dvec3(p - rounded_p)) * dvec3(last + 1) - 0.5, dvec3(0.0), dvec3(last)), lo = floor(q);
    dvec4 sum = dvec4(0.0);
    for (int c = 0; c < 8; ++c) {
        ivec3 corner = ivec3(c & 1, c >> 1 & 1, c >> 2);
        dvec3 w = mix(1.0 - (q - lo), q - lo, dvec3(corner));
        sum += w.x * w.y * w.z * dvec4(texelFetch(texels, min(ivec3(lo) + corner, last), 0));
    }
    return sum;
}
vec4 fetch(sampler3D texels, vec3 p) { return vec4(fetch_exactly(texels, p)); }

double label_exactly(sampler3D texels, vec3 p)
{
    ivec3 last = textureSize(texels, 0) - 1;
    dvec3 q = (exact_p + dvec3(p - rounded_p)) * dvec3(last + 1);
    return double(texelFetch(texels, clamp(ivec3(floor(q)), ivec3(0), last), 0).r);
}
#elif !defined TRANSITION
vec4 fetch(sampler3D texels, vec3 p) { return filtered(texels, p); }
#endif

#if PAGES > 1
vec4 fetch_page(sampler3D first, sampler3D others[PAGES - 1], vec3 p)
{
    int page = int(p.z);
    p.z -= float(page);
    vec4 texel = fetch(first, p);
    for (int i = 1; i < PAGES; ++i)
        if (page == i)
            texel = fetch(others[i - 1], p);
    return texel;
}
vec4 fetch_scalar(vec3 p) { return fetch_page(scalar, scalar_pages, p); }
vec4 fetch_direction(vec3 p) { return fetch_page(directions, direction_pages, p); }
#else
vec4 fetch_scalar(vec3 p) { return fetch(scalar, p); }
vec4 fetch_direction(vec3 p) { return fetch(directions, p); }
#endif

#if EXACT
float scalar_at(vec3 p) { return labels ? float(label_exactly(scalar, p)) : fetch_scalar(p).r; }
#elif SCALAR_WITH_DIRECTIONS
float scalar_at(vec3 p) { return fetch_direction(p).a; }
#elif defined FILTERED_BY_HAND
float scalar_at(vec3 p) { return labels ? textureLod(scalar, p, 0.0).r : fetch_scalar(p).r; }
#else
float scalar_at(vec3 p) { return fetch_scalar(p).r; }
#endif

// rgb and extinction per mm. Two fetches without a filter, which may keep only 8 bits of the weight; by texture
// coordinates, because in software OpenGL a texelFetch() finds sizes and strides lane by lane.
#if EXACT
uniform dvec2 tf_exact; // tf_scale and tf_offset
vec4 tf_row(double s, int row)
{
    double x = clamp(s * tf_exact.x + tf_exact.y, 0.0, double(tf_count - 1));
    int i = min(int(x), tf_count - 2);
    return mix(texelFetch(tf, ivec2(i, row), 0), texelFetch(tf, ivec2(i + 1, row), 0), float(x - double(i)));
}
#else
vec4 tf_row(float s, int row)
{
    float x = clamp(s * held.tf_scale + held.tf_offset, 0.0, float(held.tf_count - 1));
    float i = min(floor(x), float(held.tf_count - 2));
    vec2 place = (vec2(i, row) + 0.5) * held.tf_texel;
    return mix(textureLod(tf, place, 0.0), textureLod(tf, place + vec2(held.tf_texel.x, 0.0), 0.0), x - i);
}
#endif

#if PREINTEGRATED
// Sigma c and sigma of entry x in cell [i, i + 1]; cells -1 and tf_count - 1 hold what lies beyond the table.
vec4 emission_in(int i, float x)
{
    vec4 a = texelFetch(tf, ivec2(clamp(i, 0, held.tf_count - 1), 0), 0);
    vec4 b = texelFetch(tf, ivec2(clamp(i + 1, 0, held.tf_count - 1), 0), 0);
    vec4 e = mix(a, b, i < 0 || i >= held.tf_count - 1 ? 0.0 : x - float(i));
    return vec4(e.rgb * e.a, e.a);
}

// Simpson's rule, exact of a parabola.
vec4 cell_mean(int i, float a, float b)
{
    return (emission_in(i, a) + 4.0 * emission_in(i, 0.5 * (a + b)) + emission_in(i, b)) / 6.0;
}

// The mean color by extinction, and the mean extinction, between two texel values: tf/integral.h.
vec4 mean_between(float s0, float s1)
{
    float x0 = min(s0, s1) * held.tf_scale + held.tf_offset, x1 = max(s0, s1) * held.tf_scale + held.tf_offset;
    float last = float(held.tf_count - 1);
    int i0 = int(clamp(floor(x0), -1.0, last)), i1 = int(clamp(floor(x1), -1.0, last));
    vec4 mean;
    if (i0 == i1) {
        mean = cell_mean(i0, x0, x1);
    } else {
        vec4 sums = (texelFetch(tf_sums, ivec2(i1, 0), 0) - texelFetch(tf_sums, ivec2(i0 + 1, 0), 0)) +
                    (texelFetch(tf_sums, ivec2(i1, 1), 0) - texelFetch(tf_sums, ivec2(i0 + 1, 1), 0));
        float front = float(i0 + 1) - x0, back = x1 - float(i1);
        mean = (cell_mean(i0, x0, float(i0 + 1)) * front + sums + cell_mean(i1, float(i1), x1) * back) / (x1 - x0);
    }
    return mean.a > 0.0 ? vec4(mean.rgb / mean.a, mean.a) : vec4(0.0);
}
#endif

vec4 classify_at(vec3 p)
{
#if EXACT
    double s = labels ? label_exactly(scalar, p) : fetch_exactly(scalar, p).r;
#else
    float s = scalar_at(p);
#endif
#if TF_2D_ROWS
    float c = fetch(second_value, p).r * float(TF_2D_ROWS - 1);
    int i = min(int(c), TF_2D_ROWS - 2);
    return mix(tf_row(s, i), tf_row(s, i + 1), c - float(i));
#else
    return tf_row(s, 0);
#endif
}

vec4 classify(Segment at, vec4 where)
{
#if PREINTEGRATED
    return mean_between(scalar_at(at.front), scalar_at(at.back));
#else
    return classify_at(where.xyz);
#endif
}

#if DIRECTION_SOURCE == SOURCE_PALETTE || DIRECTION_SOURCE == SOURCE_NEAREST
vec4 entry_of(ivec3 i)
{
    i = clamp(i, ivec3(0), textureSize(palette_index, 0) - 1);
    return texelFetch(palette, ivec2(int(texelFetch(palette_index, i, 0).r), 0), 0);
}

vec4 entry_at(vec3 p)
{
    vec3 q = p * vec3(textureSize(palette_index, 0));
#if DIRECTION_SOURCE == SOURCE_NEAREST
    return entry_of(ivec3(floor(q)));
#else
    ivec3 i = ivec3(floor(q - 0.5));
    vec3 f = q - 0.5 - vec3(i);
    vec4 near = mix(mix(entry_of(i), entry_of(i + ivec3(1, 0, 0)), f.x),
                    mix(entry_of(i + ivec3(0, 1, 0)), entry_of(i + ivec3(1, 1, 0)), f.x), f.y);
    vec4 far = mix(mix(entry_of(i + ivec3(0, 0, 1)), entry_of(i + ivec3(1, 0, 1)), f.x),
                   mix(entry_of(i + ivec3(0, 1, 1)), entry_of(i + ivec3(1, 1, 1)), f.x), f.y);
    return mix(near, far, f.z);
#endif
}
#endif

#if DIRECTION_SOURCE == SOURCE_FLIPPED
// Eight exact fetches; those that oppose the one that counts most are turned (code_decode.h).
vec3 flipped_at(vec3 p)
{
    ivec3 last = textureSize(directions, 0) - 1;
    vec3 q = clamp(p * vec3(last + 1) - 0.5, vec3(0.0), vec3(last)), lo = floor(q), f = q - lo;
    vec3 d[8], pivot = vec3(0.0), sum = vec3(0.0);
    float weight[8], most = 0.0;
    for (int c = 0; c < 8; ++c) {
        ivec3 corner = ivec3(c & 1, c >> 1 & 1, c >> 2);
        vec3 w = mix(1.0 - f, f, vec3(corner));
        weight[c] = w.x * w.y * w.z;
        d[c] = texelFetch(directions, min(ivec3(lo) + corner, last), 0).rgb;
        if (weight[c] * length(d[c]) > most) {
            most = weight[c] * length(d[c]);
            pivot = d[c];
        }
    }
    for (int c = 0; c < 8; ++c)
        sum += weight[c] * iso_flip_sign(d[c], pivot) * d[c];
    return sum;
}
#endif

vec3 normal_at(vec3 p)
{
#if DIRECTION_SOURCE == SOURCE_CODES
    vec3 e = fetch_direction(p).rgb * held.direction_scale + held.direction_offset;
    return iso_shading_normal(iso_decode(DECODER, e));
#elif DIRECTION_SOURCE == SOURCE_FLIPPED
    return iso_shading_normal(flipped_at(p));
#elif DIRECTION_SOURCE == SOURCE_PALETTE || DIRECTION_SOURCE == SOURCE_NEAREST
    return iso_shading_normal(entry_at(p).xyz);
#elif DIRECTION_SOURCE == SOURCE_VECTORS && SCALAR_WITH_DIRECTIONS
    return iso_shading_normal(fetch_direction(p).rgb * held.direction_scale + held.direction_offset);
#elif DIRECTION_SOURCE == SOURCE_VECTORS
    return iso_shading_normal(fetch_direction(p).rgb);
#else
    vec3 dx = vec3(held.voxel.x, 0.0, 0.0), dy = vec3(0.0, held.voxel.y, 0.0), dz = vec3(0.0, 0.0, held.voxel.z);
    vec3 after = vec3(scalar_at(p + dx), scalar_at(p + dy), scalar_at(p + dz));
    vec3 before = vec3(scalar_at(p - dx), scalar_at(p - dy), scalar_at(p - dz));
    // Far below all values: no data. Differences are one-sided there.
    if (any(lessThan(min(after, before), vec3(-0.5)))) {
        vec3 here = vec3(scalar_at(p));
        after = mix(after, here, lessThan(after, vec3(-0.5)));
        before = mix(before, here, lessThan(before, vec3(-0.5)));
    }
    vec3 g = held.gradient_to_world * (after - before);
    return g * inversesqrt(dot(g, g) + held.on_the_fly_eps * held.on_the_fly_eps);
#endif
}

float shade(vec3 n, vec3 halfway[LIGHT_COUNT + 1])
{
    float sum = held.shading.x;
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        sum += held.light_intensity[i] * held.shading.y * abs(dot(n, held.light_direction[i]));
#if SPECULAR
        sum += held.light_intensity[i] * held.shading.z * pow(max(abs(dot(n, halfway[i])), 1e-30), held.shading.w);
#endif
    }
    return sum;
}

float shade_at(vec3 p, vec3 halfway[LIGHT_COUNT + 1])
{
#if SHADE_TABLE
    return entry_at(p).w;
#else
    return shade(normal_at(p), halfway);
#endif
}

// q of fit/extinction_scale.h. If it comes with the directions, one fetch gives both.
float extinction_scale_at(vec3 p)
{
#if EXTINCTION_SCALE == SCALE_WITH_DIRECTIONS
    return exp2(fetch_direction(p).a * held.octaves_per_texel + held.octaves_offset);
#elif EXTINCTION_SCALE == SCALE_ALONE
    return exp2(fetch(extinction_scale, p).r * held.octaves_per_texel + held.octaves_offset);
#else
    return 1.0;
#endif
}

// 1 - exp(-x) loses its digits for small x.
float opacity_of(float x)
{
    return x < 0.03 ? x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0)))) : 1.0 - exp(-x);
}

vec3[LIGHT_COUNT + 1] halfway_to(vec3 ray_direction)
{
    vec3 halfway[LIGHT_COUNT + 1];
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        vec3 sum_of_both = light_direction[i] - ray_direction;
        halfway[i] = sum_of_both / max(length(sum_of_both), 1e-30);
    }
    return halfway;
}

#if OUTPUT == OUTPUT_POINTS
#include "points.glsl"
#elif OUTPUT != OUTPUT_INTEGRAL
#include "first_hit.glsl"
#elif ROI
#include "roi.glsl"
#elif !defined OVERLAY
void main()
{
    hold_uniforms();
    Ray ray = pixel_ray();
    vec3 halfway[LIGHT_COUNT + 1] = halfway_to(ray.world);
    vec3 sum = vec3(0.0);
    float transmittance = 1.0, before = 1.0, segment_mm = float(step_mm);
    // A ray ends one segment after the light is spent, and that one adds nothing. So the start of a segment does not
    // wait for the light left by the last one, and processors work at several at a time.
#if SKIP_EMPTY
    // A look at the bricks and a sample in each turn: software GL takes 4 or 8 pixels at a time and runs both sides of a
    // branch, so a pixel that leaves empty bricks would keep the others waiting in a loop of its own.
    float until = 0.0;
    for (float k = ray.from; k < ray.to && before >= 1e-7;) {
        bool shows = leave_empty_bricks(ray, k, until);
        Segment at = segment(ray, k);
        vec4 where = address(at.p);
        vec4 c = shows ? classify(at, where) : vec4(0.0);
        c.a *= extinction_scale_at(where.xyz);
        before = transmittance;
        float weight = before >= 1e-7 ? before * opacity_of(c.a * segment_mm * at.part) : 0.0;
        sum += weight * shade_at(where.xyz, halfway) * c.rgb;
        transmittance -= weight;
        k += shows ? 1.0 : 0.0;
    }
#else
    for (float k = 0.0; k < ray.length && before >= 1e-7; k += 1.0) {
        Segment at = segment(ray, k);
        vec4 where = address(at.p);
        vec4 c = where.w > 0.0 ? classify(at, where) : vec4(0.0);
        if (c.a > 0.0)
            c.a *= extinction_scale_at(where.xyz);
        before = transmittance;
        float weight = before >= 1e-7 ? before * opacity_of(c.a * segment_mm * at.part) : 0.0;
        if (weight > 0.0)
            sum += weight * shade_at(where.xyz, halfway) * c.rgb;
        transmittance -= weight;
    }
#endif
    color = vec4(sum + transmittance * background, 1.0 - transmittance);
}
#endif
