// SPDX-License-Identifier: MIT
// es.glsl - definitions that GLSL ES 3.00 lacks, so that WebGL2 compiles the same sources. It precedes them, after #version.
// Doubles are missing: a ray is set up in floats, 4 x 2^-24 of the distance from the eye off (validate/rounding.h).
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler3D;
precision highp usampler3D;
#define double float
#define dvec2 vec2
#define dvec3 vec3
#define dvec4 vec4
#define dmat3 mat3
#define fma(a, b, c) ((a) * (b) + (c))
