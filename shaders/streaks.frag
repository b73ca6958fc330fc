#version 450 core
// Turns velocity into half streaks and puts depth beside them: one fetch for each tap.
//
// Input:  velocity (px per frame, now minus before), depth (reverse-Z, 0 = sky).
// Output: xy = half streak: how far the point moves from mid-shutter to the shutter's end, px,
//         at most radius_limit_px; z = depth times DEPTH_SCALE, so that half floats order it as far
//         as 30 km; w = length the half streak would have had without the limit.
#include "velocity.glsl"

uniform sampler2D velocity;
uniform sampler2D depth;
uniform float shutter_fraction;  // of the frame period, times the scale of the frame
uniform float radius_limit_px;

out vec4 streak;

const float DEPTH_SCALE = 1024.0;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 v = texelFetch(velocity, pixel, 0).xy;
    v = clamp(mix(v, vec2(0.0), isnan(v)), -SPEED_LIMIT_PX, SPEED_LIMIT_PX);
    streak.xy = half_streak_px(v, shutter_fraction, radius_limit_px);
    streak.z = DEPTH_SCALE * texelFetch(depth, pixel, 0).r;
    streak.w = 0.5 * shutter_fraction * length(v);
}
