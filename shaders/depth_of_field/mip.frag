#version 450 core
// Each pixel from the levels of a pyramid that are about as blurred as it should be.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width), levels of
//         mip_downsample.frag; AT_DISTANCES: depth (reverse-Z) and the eye that drew it, slices_m
//         (metres along the head's forward axis, rising).
// Output: the blurred image, linear HDR, full resolution.
//
// Level k, blown up bilinearly, spreads a point with the variance of a disc of radius 2^k px: its
// texels are 2^k wide, box and tent have variances 4^k / 12 and 4^k / 6, a disc r^2 / 4. Between
// levels the cross-fade is linear in variance, so that it is right for every radius.
// SLICES: no cross-fade. A billboard with level k stands where the radius is 2^(k - 1/2), on either
// side of the focus, and covers what is blurred more: a hard edge where a surface meets it.
// AT_DISTANCES: the billboard with level k stands at slices_m[k - 1] and covers what is behind it.
// The levels hold whatever was in the image: sharp objects have halos in blurred surroundings.
// NumPy twin: tests/oracles/pyramid.py. "Four Tricks for Fast Blurring in Software and Hardware"
// (Gamasutra 2001), trick three, and "Depth of Field: Help from the Z-buffer".
#include "eyes.glsl"
uniform eye_image colour_and_coc;
uniform eye_image levels[CHAIN];
#ifdef AT_DISTANCES
#include "coc.glsl"
#include "coc_of_depth.glsl"
uniform eye_image depth;
uniform float slices_m[CHAIN];
#endif

out vec4 blurred;

float own_px;

// How far level k has faded in over level k - 1.
float fade(int k) {
#if defined(AT_DISTANCES)
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 uv = gl_FragCoord.xy / vec2(size_of(depth));
    float near = eye.near_m * head_depth_slope(eye.tangents, eye.head_forward_in_view, uv);
    // near / z + offset_m >= slice, without the infinite distance of the sky.
    return step((slices_m[k - 1] - eye.offset_m) * texel_of(depth, pixel).r, near);
#elif defined(SLICES)
    return step(exp2(float(k) - 0.5), own_px);
#else
    float sharper = k > 1 ? exp2(2.0 * float(k - 1)) : 0.0;
    return clamp((own_px * own_px - sharper) / (exp2(2.0 * float(k)) - sharper), 0.0, 1.0);
#endif
}

// Draws a level over what is there, at its texels' own places: pixel 2^k t is the rim of texel t.
void draw(eye_image level, int k) {
    float opacity = fade(k);
    if (opacity <= 0.0)
        return;
    vec3 c = filtered_at(level, gl_FragCoord.xy / exp2(float(k)) / vec2(size_of(level))).rgb;
    blurred.rgb = opacity < 1.0 ? mix(blurred.rgb, c, opacity) : c;
}

void main() {
    vec4 p = texel_of(colour_and_coc, ivec2(gl_FragCoord.xy));
    own_px = abs(p.a);
    blurred = vec4(p.rgb, 1.0);
    for (int k = 1; k <= CHAIN; ++k)
        draw(levels[k - 1], k);
    blurred.rgb = min(blurred.rgb, HALF_MAX);
}
