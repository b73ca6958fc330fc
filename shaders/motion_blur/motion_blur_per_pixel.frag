#version 450 core
// Motion blur as most post-processing has it: the mean of samples along the pixel's OWN velocity.
//
// Input:  colour (linear HDR, filtered), velocity (half_velocity.glsl).
// Output: the mean of SAMPLES colours between the two ends of the pixel's streak; full resolution.
//         longest_bits: of half velocities that the limit shortens, the longest before, as the bits
//         of a float, which are in the order of numbers.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
//
// It does not know who hides whom: a still pixel beside a moving object stays as it is (hard
// silhouettes), and a moving background takes colour from the still object before it (halos). Here
// for comparison with motion_blur.frag. The source samples back along the velocity only; the
// samples lie around the pixel here, as the shutter is centred on the frame's pose.
// Rosado 2007, "Motion blur as a post-processing effect", GPU Gems 3, ch. 27; Chapman 2020,
// "Comfort and motion blur in VR", which builds on it.
#include "eyes.glsl"
#include "where.glsl"
#include "velocity.glsl"
#include "half_velocity.glsl"

uniform eye_image colour;

layout(std430, binding = LONGEST_BINDING) buffer Longest {
    uint longest_bits;
};

out vec4 blurred;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 whole = velocity_at(pixel);
    vec2 half_velocity = half_velocity_px(whole, shutter_fraction, max_radius_px);
    float unlimited = 0.5 * shutter_fraction * length(whole);
    WHERE (unlimited > max_radius_px)
        atomicMax(longest_bits, floatBitsToUint(unlimited));
    blurred = texel_of(colour, pixel);
    if (half_velocity == vec2(0.0))
        return;
    vec2 texel = 1.0 / vec2(size_of(colour));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < SAMPLES; ++i) {
        float along = (2.0 * float(i) + 1.0) / float(SAMPLES) - 1.0;
        sum += filtered_at(colour, (gl_FragCoord.xy + along * half_velocity) * texel).rgb;
    }
    blurred.rgb = min(sum / float(SAMPLES), HALF_MAX);
}
