#version 450 core
// A 3x3 tent, of four bilinear reads: fills the gaps between the samples of a gather.
//
// Input:  source, read bilinearly.
// Output: the same, a little blurred.
// NumPy twin: tests/oracles/half_resolution.py.
#include "eyes.glsl"
uniform eye_image source;

out vec4 blurred;

void main() {
    vec2 texel = 1.0 / vec2(size_of(source));
    vec2 place = gl_FragCoord.xy * texel;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i)
        sum += filtered_at(source, place + (vec2(i & 1, i >> 1) - 0.5) * texel);
    blurred = 0.25 * sum;
}
