// SPDX-License-Identifier: MIT
// points.glsl - the field of one brick at given places, one a pixel: what continuity is measured by.

uniform sampler2D points; // p, and the brick's index, x fastest

void main()
{
    vec4 point = texelFetch(points, ivec2(gl_FragCoord.xy), 0);
    ivec3 count = textureSize(layout_of_bricks, 0);
    int index = int(point.w);
    vec4 where = address_in(ivec3(index % count.x, index / count.x % count.y, index / (count.x * count.y)), point.xyz);
    color = vec4(scalar_at(where.xyz), fetch_direction(where.xyz).rgb);
}
