#version 450 core
// Half of an image: the average of 2x2 texels, each of which is itself an average. No blur amount.
//
// Input:  source, whose texels are TEXEL px wide: the image (1), or a level of the pyramid.
// Output: rgb. Size / (2 TEXEL), rounded up; texel t covers pixels [2 TEXEL t, 2 TEXEL (t + 1)), and
//         at the border of an odd image only those that exist, so every texel is the mean of its pixels.
// NumPy twin: tests/oracles/pyramid.py. "Four Tricks for Fast Blurring in
// Software and Hardware" (Gamasutra 2001), trick three.
#include "eyes.glsl"
uniform eye_image source;
uniform ivec2 size_px;  // of the image

out vec4 mean;

// Pixels that a texel of the source covers along each axis.
vec2 covered(ivec2 texel) {
    return clamp(vec2(size_px - texel * TEXEL), 0.0, float(TEXEL));
}

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x) {
            ivec2 texel = first + ivec2(x, y);
            vec2 share = covered(texel);
            vec3 c = texel_of(source, min(texel, size_of(source) - 1)).rgb;
            sum += share.x * share.y * vec4(c, 1.0);
        }
    mean = vec4(sum.rgb / sum.a, 1.0);
}
