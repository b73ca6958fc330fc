#version 450 core
// The average along the middle of each pixel's streak, where streaks change slowly. Long streaks take
// two steps: averages along a short part, and averages of those along the whole.
//
// Input:  source = the image, or the averages of the first step (linear HDR, filtered); velocity
//         (half_velocity.glsl).
// Output: average = the mean of SAMPLES reads between -u / PARTS and +u / PARTS of the pixel's half velocity
//         u; what does not move is copied. Full resolution, in frames of KIND LONG (frame_kinds.glsl);
//         HALVED: in those of KIND LONG_X or LONG_Y, where the first step has one average for two pixels
//         along that axis.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// Averages along 1 / n of a streak, read n times end to end, are the average of all of it: k n samples for
// k + n reads. k and n are odd: the pixel itself is one of them. Where a camera moves, nearly all that a
// pixel sees moves along with it, so that the averages there are as long as this pixel's; the rest is
// drawn by motion_blur_foreground.frag. Where all moves along one axis, light changes slowly along it after
// the first step: half as many averages tell it all, and a read between two pixels is of twice as much
// light. No noise, so the same scene point blurs alike in both eyes.
// Source: ours; the midpoint rule. NumPy twin: tests/oracles/motion.py, streak_weights.
#include "eyes.glsl"
#include "velocity.glsl"
#include "half_velocity.glsl"
#include "motion_tile_classes.glsl"

#include "streak_reads.glsl"

#ifndef PX_PER_AVERAGE
#define PX_PER_AVERAGE vec2(1.0)
#endif

out vec4 average;

void main() {
    vec2 at = gl_FragCoord.xy * PX_PER_AVERAGE;
    ivec2 pixel = min(ivec2(at), size_of(velocity) - 1);
    vec2 half_velocity = half_velocity_at(pixel);
#ifdef HALVED
    half_velocity = shortened(half_velocity);
    average = vec4(read(at), 1.0);
#else
    average = texel_of(source, pixel);
    if (dot(half_velocity, half_velocity) < LEAST_PX * LEAST_PX)
        return;
#endif
    vec2 step = half_velocity * (2.0 / float(SAMPLES * PARTS)), across = axis_across(half_velocity);
    vec3 sum = average.rgb;
    for (int i = 1; i <= SAMPLES / 2; ++i) {
        sum += read_across(at - float(i) * step, across);
        sum += read_across(at + float(i) * step, across);
    }
    average.rgb = mean_of_reads(sum / float(SAMPLES), average.rgb);
}
