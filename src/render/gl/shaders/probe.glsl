// SPDX-License-Identifier: MIT
// probe.glsl - what linear filtering makes of two texels, 0 and 1, at `count` places between their centers.
uniform sampler3D texels;
uniform float count;
out vec4 color;

void main()
{
    float fraction = gl_FragCoord.x / count;
    color = vec4(textureLod(texels, vec3(0.25 + 0.5 * fraction, 0.5, 0.5), 0.0).r);
}
