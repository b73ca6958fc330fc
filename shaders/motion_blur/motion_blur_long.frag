#version 450 core
// Motion blur where streaks are long and change slowly: the second of two steps. It
// covers the whole image in frames that have a long streak (frame_of_streaks.vert).
//
// Input:  source = the averages of that KIND of frames (streak_average.frag, filtered), velocity
//         (half_velocity.glsl).
// Output: the image as a shutter would see it, open around the frame's own time; full resolution.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// The average of the whole streak is that of PARTS averages, end to end, each of which is one read.
// Where a camera moves, nearly all that a pixel sees moves along with it, so that the averages there
// are as long as this pixel's. No noise, so the same scene point blurs alike in both eyes.
// Source: ours. NumPy twin: tests/oracles/motion.py, streak_weights.
#include "velocity.glsl"
#include "half_velocity.glsl"
#include "motion_tile_classes.glsl"

#include "streak_reads.glsl"

out vec4 blurred;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 half_velocity = half_velocity_at(pixel);
#ifdef HALVED
    half_velocity = shortened(half_velocity);
    blurred = vec4(read(gl_FragCoord.xy), 1.0);
#else
    blurred = texelFetch(source, pixel, 0);
    if (dot(half_velocity, half_velocity) < LEAST_PX * LEAST_PX)
        return;
#endif
    vec2 step = half_velocity * (2.0 / float(PARTS)), across = axis_across(half_velocity);
    vec3 sum = blurred.rgb;
    for (int i = 1; i <= PARTS / 2; ++i) {
        sum += read_across(gl_FragCoord.xy - float(i) * step, across);
        sum += read_across(gl_FragCoord.xy + float(i) * step, across);
    }
    blurred.rgb = mean_of_reads(sum / float(PARTS), blurred.rgb);
}
