// SPDX-License-Identifier: MIT
// held.glsl - the uniforms that samples are made with, as values that are loaded once a pixel.
//
// Mesa's software OpenGL loads a uniform for each of its 8 lanes by itself, with a test of the bounds, wherever a loop
// reads it. A copy does not help, because compilers undo it; what an operation gives, they keep.

float hold(float x) { return max(x, -3.0e38); }
vec3 hold(vec3 x) { return max(x, vec3(-3.0e38)); }
vec4 hold(vec4 x) { return max(x, vec4(-3.0e38)); }
int hold(int x) { return max(x, -0x7fffffff); }
ivec3 hold(ivec3 x) { return max(x, ivec3(-0x7fffffff)); }

// Fields are uniforms of the same names unless a comment names another.
struct Held {
    float tf_scale, tf_offset;
    int tf_count;
    vec2 tf_texel; // a texel of `tf` in texture coordinates
    float direction_scale, direction_offset, octaves_per_texel, octaves_offset;
    vec3 light_direction[LIGHT_COUNT + 1];
    float light_intensity[LIGHT_COUNT + 1];
    vec4 shading;
#if DIRECTION_SOURCE == SOURCE_ON_THE_FLY
    vec3 voxel;
    mat3 gradient_to_world;
    float on_the_fly_eps;
#endif
#if SKIP_EMPTY
    vec3 bricks_per_volume;
    ivec3 last_occupancy; // the last brick of `occupancy`
#endif
#if BRICKS
    vec3 brick_in_cache, last_node;
    vec3 last_brick, layout_texel; // of `layout_of_bricks`: its last brick, and a texel in texture coordinates
#endif
};
Held held;

// To be called before anything else is.
void hold_uniforms()
{
    held.tf_scale = hold(tf_scale);
    held.tf_offset = hold(tf_offset);
    held.tf_count = hold(tf_count);
    held.tf_texel = 1.0 / vec2(textureSize(tf, 0));
    held.direction_scale = hold(direction_scale);
    held.direction_offset = hold(direction_offset);
    held.octaves_per_texel = hold(octaves_per_texel);
    held.octaves_offset = hold(octaves_offset);
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        held.light_direction[i] = hold(light_direction[i]);
        held.light_intensity[i] = hold(light_intensity[i]);
    }
    held.shading = hold(shading);
#if DIRECTION_SOURCE == SOURCE_ON_THE_FLY
    held.voxel = hold(voxel);
    held.gradient_to_world =
        mat3(hold(gradient_to_world[0]), hold(gradient_to_world[1]), hold(gradient_to_world[2]));
    held.on_the_fly_eps = hold(on_the_fly_eps);
#endif
#if SKIP_EMPTY
    held.bricks_per_volume = hold(bricks_per_volume);
    held.last_occupancy = hold(textureSize(occupancy, 0) - 1);
#endif
#if BRICKS
    held.brick_in_cache = hold(brick_in_cache);
    held.last_node = hold(last_node);
    held.last_brick = vec3(hold(textureSize(layout_of_bricks, 0) - 1));
    held.layout_texel = 1.0 / (held.last_brick + 1.0);
#endif
}
