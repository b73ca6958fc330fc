#version 450 core
// Radiance of the sky; drawn at depth 0, where the depth test leaves only untouched samples.
//
// Input:  direction of the pixel.
// Output: linear HDR radiance; VELOCITY: AS_THE_EYE (include/velocity.glsl), with LENS px per frame.
#include "view.glsl"
#include "light.glsl"
#include "sky.glsl"

in vec3 direction;
layout(location = 0) out vec4 radiance;
#ifdef VELOCITY
#include "velocity.glsl"
#ifdef LENS
in vec4 present_clip;
in vec4 previous_clip;
#endif
layout(location = 1) out vec2 velocity;
#endif

void main() {
    radiance = vec4(sky_radiance(normalize(direction)), 1.0);
#ifdef VELOCITY
#ifdef LENS
    velocity = velocity_px(interpolateAtSample(present_clip, 0),
                           interpolateAtSample(previous_clip, 0), image_size_px.xy);
#else
    velocity = vec2(AS_THE_EYE, 0.0);
#endif
#endif
}
