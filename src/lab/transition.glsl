// SPDX-License-Identifier: MIT
// transition.glsl - bricks whose samples lie inside them, with the transitions of [beyer-2008] (lab/warp.h).
//
// TRANSITION (lab/warp_map.h): 0 none, so that bricks jump at their faces; 1 as the paper has it, one fetch; 2 corrected,
// two fetches. Positions p are bricks, as in raycast.glsl.

uniform usampler3D coarse_neighbors; // 26 bits per brick; 0 for coarse ones
uniform float brick_side;             // voxels of a brick of level 0

// The second fetch of the place that address_in() gave last.
vec3 foot_place = vec3(0.0);
float foot_part = 0.0;

// Place of p in the cache for a brick; w is 0 if it is left out. In the cache a fine brick begins at its border.
vec4 address_in(vec3 brick, vec3 p)
{
    vec4 place = layout_of(brick);
    vec3 in_brick = clamp(clamp(p, vec3(0.0), held.last_node) - brick, 0.0, 1.0);
#if TRANSITION
    foot_part = 0.0;
    vec3 inwards = min(in_brick, 1.0 - in_brick) * brick_side;
    if (min(inwards.x, min(inwards.y, inwards.z)) < 0.5) {
        uint coarse = texelFetch(coarse_neighbors, ivec3(brick), 0).r;
        iso_warp_fetch at = iso_warp_place(in_brick * brick_side, brick_side, coarse, TRANSITION);
        // Coarse bricks have no neighbors that count: their own places stay as they are.
        in_brick = coarse != 0u ? at.top / brick_side : in_brick;
#if TRANSITION == ISO_TRANSITION_CORRECTED
        foot_part = at.part;
        vec4 there = layout_of(brick + at.step);
        foot_place = there.xyz + (at.foot / brick_side - at.step) * there.w * held.brick_in_cache;
#endif
    }
#endif
    return vec4(place.xyz + in_brick * place.w * held.brick_in_cache, place.w);
}

vec4 fetch(sampler3D texels, vec3 p)
{
    vec4 top = filtered(texels, p);
#if TRANSITION == ISO_TRANSITION_CORRECTED
    if (foot_part > 0.0)
        top = mix(top, filtered(texels, foot_place), foot_part);
#endif
    return top;
}
