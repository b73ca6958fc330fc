#version 450 core
// Motion blur in one step, where streaks change slowly: the average along the pixel's own. It covers
// the whole image, in frames whose longest streak is short (frame_of_streaks.vert).
//
// Input:  source = the image (linear HDR, filtered), velocity (half_velocity.glsl).
// Output: the image as a shutter would see it, open around the frame's own time; full resolution.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// Where a camera moves, nearly all that a pixel sees moves along with it, and nothing is uncovered;
// the rest is drawn by motion_blur_foreground.frag.
//
// Counted in pixels along the longer axis of the image, the pixel itself counts for as long as the
// streak is over it. What is left on either side is divided evenly among PAIRS reads at the middle of
// their parts. Up to 2 px apart the filter reads every pixel. Where they are farther apart, the pixel's
// own part grows until all are even. No noise, so the same scene point blurs alike in both eyes.
// Source: ours; the midpoint rule. NumPy twin: tests/oracles/motion.py, streak_weights.
#include "eyes.glsl"
#include "velocity.glsl"
#include "half_velocity.glsl"
#include "motion_tile_classes.glsl"

out vec4 blurred;

#include "streak_reads.glsl"

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 half_velocity = half_velocity_at(pixel);
    blurred = texel_of(source, pixel);
    if (dot(half_velocity, half_velocity) < LEAST_PX * LEAST_PX)
        return;
    vec2 extent = abs(half_velocity);
    float reach = max(extent.x, extent.y);
    float over_it = reach < 1.0 ? reach * (2.0 - reach) : 1.0;  // time_over(0, reach)
    float even = 2.0 * reach / float(2 * PAIRS + 1);
    float own = max(over_it, min(even, reach - float(2 * PAIRS) + 0.5));
    float part = (reach - 0.5 * own) / float(PAIRS);
    vec2 step = half_velocity / reach;
    vec2 across = axis_across(half_velocity);
    float first = reach < 1.0 ? 0.75 - 0.5 * part * float(PAIRS - 1) : 0.5 * (own + part);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < PAIRS; ++i) {
        vec2 offset = (first + float(i) * part) * step;
        sum += read_across(gl_FragCoord.xy - offset, across);
        sum += read_across(gl_FragCoord.xy + offset, across);
    }
    vec3 mean = (own * blurred.rgb + part * sum) / (2.0 * reach);
    blurred.rgb = mean_of_reads(mean, blurred.rgb);
}
