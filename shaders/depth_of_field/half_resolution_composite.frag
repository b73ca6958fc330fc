#version 450 core
// Puts what was blurred at half resolution over the sharp image.
//
// Input:  colour_and_coc of colour_and_coc.frag (only its colour), half_image: rgb times opacity, and
//         opacity, read bilinearly.
// Output: the image, linear HDR, full resolution. Where nothing is blurred, bit for bit the sharp one.
// NumPy twin: tests/oracles/half_resolution.py. As the last passes of KinoBokeh and of Filament.
#include "eyes.glsl"
uniform eye_image colour_and_coc;
uniform eye_image half_image;

out vec4 image;

void main() {
    vec3 sharp = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy)).rgb;
    vec4 soft = filtered_at(half_image, gl_FragCoord.xy / (2.0 * vec2(size_of(half_image))));
    image = vec4(min(soft.rgb + (1.0 - soft.a) * sharp, HALF_MAX), 1.0);
}
