// SPDX-License-Identifier: MIT
// points.glsl - the field of one brick at given places, one a pixel: what continuity is measured by.

uniform sampler2D points; // p, and the brick's index, x fastest

void main()
{
    hold_uniforms();
    vec4 point = texelFetch(points, ivec2(gl_FragCoord.xy), 0);
    ivec3 count = textureSize(layout_of_bricks, 0);
    int index = int(point.w);
    ivec3 brick = ivec3(index % count.x, index / count.x % count.y, index / (count.x * count.y));
    vec4 where = address_in(vec3(brick), point.xyz);
    color = vec4(scalar_at(where.xyz), fetch_direction(where.xyz).rgb);
}
