// SPDX-License-Identifier: MIT
// display.glsl - converts the linear picture for the screen: sRGB; two pictures divided by a line, or their difference.
uniform sampler2D picture, other;
uniform int mode;        // 0: picture; 1: picture left of the line, other right of it; 2: their difference
uniform float line;      // 0 left, 1 right
uniform float amplified; // factor of the difference
uniform vec2 screen;     // pixels
out vec4 color;

vec3 srgb(vec3 c)
{
    c = clamp(c, 0.0, 1.0);
    return mix(1.055 * pow(max(c, 1e-6), vec3(1.0 / 2.4)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308))));
}

vec3 at(sampler2D image, vec2 uv)
{
    return texture(image, uv).rgb;
}

void main()
{
    vec2 uv = vec2(gl_FragCoord.x, screen.y - gl_FragCoord.y) / screen; // row 0 of a picture is its top
    vec3 c = at(picture, uv);
    if (mode == 1) {
        float from = gl_FragCoord.x - line * screen.x;
        c = srgb(from < 0.0 ? c : at(other, uv));
        if (abs(from) < 1.0)
            c = vec3(1.0);
    } else if (mode == 2) {
        vec3 d = abs(c - at(other, uv)) * amplified;
        float worst = clamp(max(d.r, max(d.g, d.b)), 0.0, 1.0);
        // Black, violet, orange, white: lightness increases evenly, so that color-blind people can distinguish them.
        c = worst < 0.5 ? mix(vec3(0.03, 0.03, 0.09), vec3(0.69, 0.17, 0.41), worst * 2.0)
                        : mix(vec3(0.69, 0.17, 0.41), vec3(0.99, 0.96, 0.75), worst * 2.0 - 1.0);
    } else {
        c = srgb(c);
    }
    color = vec4(c, 1.0);
}
