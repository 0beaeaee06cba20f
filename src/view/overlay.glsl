// SPDX-License-Identifier: MIT
// overlay.glsl - a second volume with its own transfer function, along the same rays: extinctions add up, and each
// volume's emission counts by its part of the extinction. Follows raycast.glsl.

uniform sampler3D over_scalar;
uniform sampler2D over_tf;
uniform float over_tf_scale, over_tf_offset; // texel value to entry
uniform int over_tf_count;
uniform bool over_labels;                    // are not filtered
uniform mat3 over_to_index;
uniform vec3 over_position_index, over_box_index;
uniform mat3 over_gradient_to_world;         // like gradient_to_world
uniform float over_eps;
#if SKIP_EMPTY
uniform usampler3D over_occupancy;
uniform vec3 over_bricks_per_volume;

// If a volume may show something in the segments before `until`.
struct Known { bool shows; float until; };

Known look(usampler3D bricks, vec3 per_volume, Ray ray, float n, Known known)
{
    if (n < known.until)
        return known;
    float k = n - ray.number, end;
    if (ray.length <= 0.0 || k >= ray.length)
        return Known(false, 1e30);
    if (k < 0.0)
        return Known(false, ray.number);
    bool empty = is_empty(bricks, per_volume, textureSize(bricks, 0) - 1, ray, k, end);
    return Known(!empty, end + ray.number);
}
#endif

float over_at(vec3 p) { return over_labels ? textureLod(over_scalar, p, 0.0).r : filtered(over_scalar, p).r; }

vec4 over_classify(vec3 p)
{
    float x = clamp(over_at(p) * over_tf_scale + over_tf_offset, 0.0, float(over_tf_count - 1));
    float i = min(floor(x), float(over_tf_count - 2)), texel = 1.0 / float(over_tf_count);
    vec2 place = vec2((i + 0.5) * texel, 0.5); // by coordinates, like tf_row()
    return mix(textureLod(over_tf, place, 0.0), textureLod(over_tf, place + vec2(texel, 0.0), 0.0), x - i);
}

// Differences of the scalar, as in normal_at().
vec3 over_normal(vec3 p)
{
    vec3 voxel = 1.0 / over_box_index, here = vec3(over_at(p));
    vec3 dx = vec3(voxel.x, 0.0, 0.0), dy = vec3(0.0, voxel.y, 0.0), dz = vec3(0.0, 0.0, voxel.z);
    vec3 after = vec3(over_at(p + dx), over_at(p + dy), over_at(p + dz));
    vec3 before = vec3(over_at(p - dx), over_at(p - dy), over_at(p - dz));
    after = mix(after, here, lessThan(after, vec3(-0.5)));
    before = mix(before, here, lessThan(before, vec3(-0.5)));
    vec3 g = over_gradient_to_world * (after - before);
    return g * inversesqrt(dot(g, g) + over_eps * over_eps);
}

// One volume's part of a segment: its optical depth, its color and its shade.
struct Part { float depth; vec3 color; float shade; };

Part own_part(Ray ray, float k, vec3 halfway[LIGHT_COUNT + 1])
{
    Part part = Part(0.0, vec3(0.0), 0.0);
    if (k < 0.0 || k >= ray.length)
        return part;
    Segment at = segment(ray, k);
    float segment_mm = float(step_mm);
#if ROI
    vec4 e = emission_at(at.p, halfway);
    if (e.a > 0.0)
        part = Part(e.a * segment_mm * at.part, e.rgb / e.a, 1.0);
#else
    vec4 where = address(at.p), c = where.w > 0.0 ? classify(at, where) : vec4(0.0);
    if (c.a > 0.0)
        part = Part(c.a * extinction_scale_at(where.xyz) * segment_mm * at.part, c.rgb, shade_at(where.xyz, halfway));
#endif
    return part;
}

Part over_part(Ray ray, float k, vec3 halfway[LIGHT_COUNT + 1])
{
    Part part = Part(0.0, vec3(0.0), 0.0);
    if (k < 0.0 || k >= ray.length)
        return part;
    Segment at = segment(ray, k);
    vec4 c = over_classify(at.p);
    if (c.a > 0.0)
        part = Part(c.a * float(step_mm) * at.part, c.rgb, shade(over_normal(at.p), halfway));
    return part;
}

void main()
{
    hold_uniforms();
    Line line = pixel_line(to_index, position_index), other = pixel_line(over_to_index, over_position_index);
    Ray ray = ray_along(line, part_kept(line, part_inside(line, box_index)), index_scale, index_offset);
    Ray over = ray_along(other, part_kept(line, part_inside(other, over_box_index)), 1.0 / over_box_index, vec3(0.0));
    vec3 halfway[LIGHT_COUNT + 1] = halfway_to(ray.world);
    vec3 sum = vec3(0.0);
    float transmittance = 1.0, before = 1.0;
    // A ray that misses a volume has length 0 there.
    float from = min(ray.length > 0.0 ? ray.number : 1e30, over.length > 0.0 ? over.number : 1e30);
    float to = max(ray.length > 0.0 ? ray.number + ray.length : 0.0,
                   over.length > 0.0 ? over.number + over.length : 0.0);
#if SKIP_EMPTY
    Known of_own = Known(false, from), of_other = of_own;
#endif
    for (float n = from; n < to && before >= 1e-7; n += 1.0) {
        bool own_shows = true, other_shows = true;
#if SKIP_EMPTY
        of_own = look(occupancy, held.bricks_per_volume, ray, n, of_own);
        of_other = look(over_occupancy, over_bricks_per_volume, over, n, of_other);
        own_shows = of_own.shows;
        other_shows = of_other.shows;
        if (!own_shows && !other_shows) {
            n = min(of_own.until, of_other.until) - 1.0;
            continue;
        }
#endif
        Part a = Part(0.0, vec3(0.0), 0.0), b = a;
        if (own_shows)
            a = own_part(ray, n - ray.number, halfway);
        if (other_shows)
            b = over_part(over, n - over.number, halfway);
        float depth = a.depth + b.depth, share = b.depth > 0.0 ? a.depth / depth : 1.0;
        before = transmittance;
        float weight = before >= 1e-7 ? before * opacity_of(depth) : 0.0;
        if (weight > 0.0)
            sum += weight * share * a.shade * a.color;
        if (weight > 0.0 && b.depth > 0.0)
            sum += weight * (1.0 - share) * b.shade * b.color;
        transmittance -= weight;
    }
    color = vec4(sum + transmittance * background, 1.0 - transmittance);
}
