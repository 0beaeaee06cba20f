// SPDX-License-Identifier: MIT
// roi.glsl - a finer level inside a box, the other around it, and a band in which their emission and absorption are blended:
// scene/roi.h. The finer level has a scalar, directions (of the same source) and a TF of its own.

uniform sampler3D roi_scalar, roi_directions;
uniform sampler2D roi_tf;
uniform float roi_tf_scale, roi_tf_offset;
uniform int roi_tf_count;
uniform vec3 roi_place_scale, roi_place_offset; // p to texture coordinates of the finer level
uniform vec3 roi_lo, roi_hi;                    // the box, in the index of the level around it
uniform float roi_band;
uniform vec3 index_per_p;

float roi_weight(vec3 p)
{
    vec3 index = p * index_per_p, far = max(roi_lo - index, index - roi_hi);
    float outside = max(max(far.x, far.y), far.z);
    float u = outside > 0.0 ? max(1.0 - outside / max(roi_band, 1e-30), 0.0) : 1.0;
    return u * u * (3.0 - 2.0 * u);
}

vec4 roi_classify(vec3 q)
{
    float x = clamp(filtered(roi_scalar, q).r * roi_tf_scale + roi_tf_offset, 0.0, float(roi_tf_count - 1));
    int i = min(int(x), roi_tf_count - 2);
    return mix(texelFetch(roi_tf, ivec2(i, 0), 0), texelFetch(roi_tf, ivec2(i + 1, 0), 0), x - float(i));
}

vec3 roi_normal(vec3 q)
{
    vec3 e = filtered(roi_directions, q).rgb;
#if DIRECTION_SOURCE == SOURCE_CODES
    return iso_shading_normal(iso_decode(DECODER, e * held.direction_scale + held.direction_offset));
#else
    return iso_shading_normal(e);
#endif
}

// Sigma c shade, and sigma.
vec4 emission_at(vec3 p, vec3 halfway[LIGHT_COUNT + 1])
{
    float w = roi_weight(p);
    vec4 sum = vec4(0.0);
    if (w < 1.0) {
        vec4 c = classify_at(p);
        if (c.a > 0.0)
            sum = (1.0 - w) * c.a * extinction_scale_at(p) * vec4(shade_at(p, halfway) * c.rgb, 1.0);
    }
    if (w > 0.0) {
        vec3 q = p * roi_place_scale + roi_place_offset;
        vec4 c = roi_classify(q);
        if (c.a > 0.0)
            sum += w * c.a * vec4(shade(roi_normal(q), halfway) * c.rgb, 1.0);
    }
    return sum;
}

#ifndef OVERLAY
void main()
{
    hold_uniforms();
    Ray ray = pixel_ray();
    vec3 halfway[LIGHT_COUNT + 1] = halfway_to(ray.world);
    vec3 sum = vec3(0.0);
    float transmittance = 1.0, segment_mm = float(step_mm);
    for (float k = 0.0; k < ray.length && transmittance >= 1e-7; k += 1.0) {
        Segment at = segment(ray, k);
        vec4 e = emission_at(at.p, halfway);
        float weight = transmittance * opacity_of(e.a * segment_mm * at.part);
        if (weight > 0.0)
            sum += weight / e.a * e.rgb;
        transmittance -= weight;
    }
    color = vec4(sum + transmittance * background, 1.0 - transmittance);
}
#endif
