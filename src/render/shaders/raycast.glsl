// raycast.glsl - the rendering equation by midpoint segments, one ray a pixel.
//
// Positions are index coordinates of the level relative to the centre of the box, so that numbers stay as small as the
// volume and a far camera costs no digits: each ray starts from its point on the plane through the box's centre at
// right angles to the view, and t counts millimetres from there.
//
// Defined before this file: DIRECTION_SOURCE (0 codes, 1 decoded or float, 2 on the fly), DECODER (of code_decode.h), LIGHT_COUNT.

uniform vec2 image_size;
uniform bool orthographic;
uniform vec2 half_image;          // tan of the half angles, or mm when orthographic
uniform vec3 forward_world, right_world, up_world;
uniform vec3 forward_index, right_index, up_index; // index steps of one mm along these
uniform vec3 plane_center;        // where the view axis meets the plane
uniform float plane_depth;        // mm from the camera to the plane
uniform vec3 box_half;
uniform float step_mm;

uniform sampler3D scalar;
uniform vec3 texture_scale, texture_offset;
uniform sampler2D tf;
uniform float tf_scale, tf_offset; // texel value to entry
uniform int tf_count;

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

struct Ray {
    vec3 origin, direction; // index, relative to the box centre; index per mm
    vec3 world;             // unit
    float camera;           // t of the camera, at most 0 unless it is beyond the plane
};

Ray pixel_ray()
{
    // Row 0 is the top of the image and the first row of the target.
    vec2 p = (2.0 * gl_FragCoord.xy / image_size - 1.0) * vec2(half_image.x, -half_image.y);
    Ray ray;
    if (orthographic) {
        ray.origin = plane_center + (p.x * right_index + p.y * up_index);
        ray.direction = forward_index;
        ray.world = forward_world;
        ray.camera = -plane_depth;
    } else {
        float norm = sqrt(1.0 + dot(p, p));
        ray.origin = plane_center + plane_depth * (p.x * right_index + p.y * up_index);
        ray.direction = (forward_index + p.x * right_index + p.y * up_index) / norm;
        ray.world = (forward_world + p.x * right_world + p.y * up_world) / norm;
        ray.camera = -plane_depth * norm;
    }
    return ray;
}

vec2 box_range(Ray ray)
{
    vec3 direction = mix(ray.direction, vec3(1e-30), lessThan(abs(ray.direction), vec3(1e-30)));
    vec3 a = (-box_half - ray.origin) / direction, b = (box_half - ray.origin) / direction;
    vec3 near = min(a, b), far = max(a, b);
    return vec2(max(max(near.x, near.y), max(near.z, ray.camera)), min(min(far.x, far.y), far.z));
}

float scalar_at(vec3 p) { return textureLod(scalar, p, 0.0).r; }

// rgb and extinction per mm. Two exact fetches: texture filters may keep only 8 bits of the weight.
vec4 classify(float s)
{
    float x = clamp(s * tf_scale + tf_offset, 0.0, float(tf_count - 1));
    int i = min(int(x), tf_count - 2);
    return mix(texelFetch(tf, ivec2(i, 0), 0), texelFetch(tf, ivec2(i + 1, 0), 0), x - float(i));
}

vec3 normal_at(vec3 p)
{
#if DIRECTION_SOURCE == 0
    vec3 e = textureLod(directions, p, 0.0).rgb * direction_scale + direction_offset;
    return iso_shading_normal(iso_decode(DECODER, e));
#elif DIRECTION_SOURCE == 1
    return iso_shading_normal(textureLod(directions, p, 0.0).rgb);
#else
    vec3 dx = vec3(voxel.x, 0.0, 0.0), dy = vec3(0.0, voxel.y, 0.0), dz = vec3(0.0, 0.0, voxel.z);
    vec3 g = gradient_to_world * vec3(scalar_at(p + dx) - scalar_at(p - dx), scalar_at(p + dy) - scalar_at(p - dy),
                                      scalar_at(p + dz) - scalar_at(p - dz));
    return g * inversesqrt(dot(g, g) + on_the_fly_eps * on_the_fly_eps);
#endif
}

float shade(vec3 n, vec3 halfway[LIGHT_COUNT + 1])
{
    float sum = shading.x;
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        float specular = pow(max(abs(dot(n, halfway[i])), 1e-30), shading.w);
        sum += light_intensity[i] * (shading.y * abs(dot(n, light_direction[i])) + shading.z * specular);
    }
    return sum;
}

// 1 - exp(-x) loses its digits for small x.
float opacity_of(float x)
{
    return x < 0.03 ? x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0)))) : 1.0 - exp(-x);
}

void main()
{
    Ray ray = pixel_ray();
    vec2 range = box_range(ray);
    vec3 halfway[LIGHT_COUNT + 1];
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        vec3 sum_of_both = light_direction[i] - ray.world;
        halfway[i] = sum_of_both / max(length(sum_of_both), 1e-30);
    }

    // Segment k of the ray is [k, k + 1] steps from the camera; `first` is where the first one starts.
    float first = floor((range.x - ray.camera) / step_mm) * step_mm + ray.camera;
    vec3 start = ray.origin * texture_scale + texture_offset, velocity = ray.direction * texture_scale;
    vec3 sum = vec3(0.0);
    float transmittance = 1.0;
    for (float k = 0.0; transmittance >= 1e-7; k += 1.0) {
        float begin = first + k * step_mm;
        if (begin >= range.y)
            break;
        // What the box cuts off; exactly 0 inside, so that whole segments keep their exact length.
        float cut_front = max(range.x - begin, 0.0), cut_back = max(begin + step_mm - range.y, 0.0);
        float length_mm = max(step_mm - cut_front - cut_back, 0.0);
        float t = first + (k + 0.5) * step_mm + 0.5 * (cut_front - cut_back);
        vec3 p = start + t * velocity;
        vec4 c = classify(scalar_at(p));
        float weight = transmittance * opacity_of(c.a * length_mm);
        if (weight > 0.0)
            sum += weight * shade(normal_at(p), halfway) * c.rgb;
        transmittance -= weight;
    }
    color = vec4(sum + transmittance * background, 1.0 - transmittance);
}
