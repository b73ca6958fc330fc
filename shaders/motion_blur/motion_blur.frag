#version 450 core
// Motion blur where streaks change slowly from pixel to pixel: the average along the pixel's own.
//
// Input:  colour (linear HDR, filtered), velocity (half_velocity.glsl).
// Output: the image as a shutter would see it, open around the frame's own time; full resolution.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// Where a camera moves, nearly all that a pixel sees moves along with it, and nothing is uncovered;
// the rest is drawn over this by motion_blur_foreground.frag.
//
// The pixel itself counts for as long as the streak is over it. What is left on either side is
// divided evenly among taps at the middle of their parts, counted in pixels along the longer axis
// of the image. Up to 2 px apart the filter reads every pixel, so a short streak takes few taps: one
// on either side up to 2.5 px. Beyond `few_taps` they move apart, and from 1 / `taps_per_px` on
// their number grows with the streak. No noise, so the same scene point blurs alike in both eyes.
// Source: ours; the midpoint rule. NumPy twin: tests/oracles/motion.py, streak_taps.
#include "velocity.glsl"
#include "half_velocity.glsl"
#include "motion_tile_classes.glsl"

uniform sampler2D colour;
uniform float taps_per_px;
uniform float few_taps;

out vec4 blurred;

vec2 texel = 1.0 / vec2(textureSize(colour, 0));

vec3 read(vec2 at_px) {
    return textureLod(colour, at_px * texel, 0.0).rgb;
}

#ifdef CUBIC
// Catmull-Rom across the streak, on the axis along which it is shorter: a bilinear read blurs there
// as well. The two middle rows are read at once, where the filter weighs them as the curve does.
// The mean is no brighter or darker than all that was read.
vec3 least = vec3(65504.0), greatest = vec3(0.0);

vec3 read_across(vec2 at_px, vec2 across) {
    float t = dot(fract(at_px - 0.5), across);
    vec2 row = at_px - t * across;
    float before = t * (t * (1.0 - 0.5 * t) - 0.5), after = t * t * (0.5 * t - 0.5);
    float first = 1.0 + t * t * (1.5 * t - 2.5), second = t * (0.5 + t * (2.0 - 1.5 * t));
    float middle = first + second;
    vec3 a = read(row - across), b = read(row + second / middle * across);
    vec3 c = read(row + 2.0 * across);
    least = min(least, min(min(a, b), c));
    greatest = max(greatest, max(max(a, b), c));
    return before * a + middle * b + after * c;
}
#else
vec3 read_across(vec2 at_px, vec2 across) {
    return read(at_px);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 half_velocity = half_velocity_at(pixel);
    blurred = texelFetch(colour, pixel, 0);
    bool moves = dot(half_velocity, half_velocity) >= LEAST_PX * LEAST_PX;
    vec2 extent = abs(half_velocity);
    float reach = max(max(extent.x, extent.y), 1e-6);
    float own = reach < 1.0 ? reach * (2.0 - reach) : 1.0;  // time_over(0, reach)
    float beyond = reach - 0.5 * own;
    float taps = max(min(ceil(0.5 * (reach - 0.5)), few_taps), ceil(taps_per_px * (reach - 0.5)));
    taps = max(taps, 1.0);
    float part = beyond / taps;
    vec2 step = half_velocity / reach;
    vec2 across = extent.x < extent.y ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    vec2 offset = (reach < 1.0 ? 0.75 : 0.5 + 0.5 * part) * step;
    vec3 sum = vec3(0.0);
    // As `do`, it goes through once where one tap is enough: lanes of a block leave at its end.
    do {
        sum += read_across(gl_FragCoord.xy - offset, across);
        sum += read_across(gl_FragCoord.xy + offset, across);
        offset += part * step;
        taps -= 1.0;
    } while (moves && taps > 0.5);
    vec3 mean = (own * blurred.rgb + part * sum) / (2.0 * reach);
#ifdef CUBIC
    mean = clamp(mean, min(least, blurred.rgb), max(greatest, blurred.rgb));
#endif
    if (moves)
        blurred.rgb = min(mean, 65504.0);
}
