#version 450 core
// A Gaussian along one axis, as wide as the pixel's own disc.
//
// Input:  source: colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width), or the
//         result of the other axis; read bilinearly.
// Output: rgb; a = the radius, unchanged.
//
// A disc of radius r has the variance r^2 / 4 along each axis: sigma = r / 2. Two texels are one read,
// at the place between them that weighs them right. No depth is compared.
// NumPy twin: tests/oracles/half_resolution.py. As the Gaussian depth of field of Bevy.
#include "eyes.glsl"
uniform eye_image source;
uniform vec2 axis_of_eye[EYES];  // (1, 0) or (0, pixel_aspect)
vec2 axis = axis_of_eye[EYE];

out vec4 blurred;

void main() {
    vec2 size = vec2(size_of(source));
    vec4 p = texel_of(source, ivec2(gl_FragCoord.xy));
    float sigma = 0.5 * abs(p.a) * (axis.x + axis.y);  // in pixels of this axis
    vec2 step_px = sign(axis);
    int pixels = int(ceil(REACH * sigma));
    vec4 sum = vec4(p.rgb, 1.0);
    for (int i = 1; i <= pixels; i += 2) {
        float first = exp(-0.5 * float(i * i) / (sigma * sigma));
        float second = exp(-0.5 * float((i + 1) * (i + 1)) / (sigma * sigma));
        float weight = first + second;
        if (weight <= 0.0)
            break;
        vec2 away = (float(i) + second / weight) * step_px;
        vec3 c = filtered_at(source, (gl_FragCoord.xy + away) / size).rgb;
        c += filtered_at(source, (gl_FragCoord.xy - away) / size).rgb;
        sum += weight * vec4(c, 2.0);
    }
    blurred = vec4(min(sum.rgb / sum.a, HALF_MAX), p.a);
}
