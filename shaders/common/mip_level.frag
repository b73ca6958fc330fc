#version 450 core
// The whole image at one MIP level, blown up to full size: after relocations, and behind a foreground.
//
// Input:  image (linear HDR), levels of common/mip_downsample.frag (level 1 first); level, above 0 and
//         at most CHAIN. A texel of level k is 2^k px WIDE.
// Output: the blurred image, linear HDR, full resolution.
//
// Trilinear: each level is blown up bilinearly, and between levels k and k + 1 the image cross-fades
// linearly, which "is visually indistinguishable from an extremely smooth change in the level".
// NumPy twin: tests/oracles/mip_level.py. "Four Tricks for Fast Blurring in Software and
// Hardware" (Gamasutra 2001), trick three, "MIP-Mapping Abused for Full-Screen Blurs".
#include "eyes.glsl"
uniform eye_image image;
uniform eye_image levels[CHAIN];
uniform float level;

out vec4 blurred;

// Texel t of level k begins at pixel 2^k t.
vec3 blown_up(eye_image texels, int k) {
    vec2 size = vec2(size_of(texels));
    return filtered_at(texels, gl_FragCoord.xy / exp2(float(k)) / size).rgb;
}

void main() {
    vec4 sharp = texel_of(image, ivec2(gl_FragCoord.xy));
    vec3 sum = max(1.0 - level, 0.0) * sharp.rgb;
    for (int k = 1; k <= CHAIN; ++k) {
        float share = 1.0 - abs(level - float(k));
        if (share > 0.0)
            sum += share * blown_up(levels[k - 1], k);
    }
    blurred = vec4(min(sum, HALF_MAX), sharp.a);
}
