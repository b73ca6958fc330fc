#version 450 core
// Makes one sample per pixel: colour is the mean, depth and velocity are those of one sample.
//
// A mean of depths lies on no surface, a mean of velocities moves nothing: both stay whole. The
// nearest sample is taken: a pixel on a silhouette then counts as foreground, whose blur it gets,
// and does not leave a line of the foreground's colour in the background's blur.
//
// Velocity is taken where depth is, at the same sample. What stands still in the world and is only
// moved by the eye's motion has its velocity computed from that depth: exact there, whatever the
// triangle does at the other samples, and exactly zero where the eye has not moved.
//
// BY_BRIGHTNESS: a sample weighs 1 / (1 + its brightest channel, exposed), so that pixels on the edge of
// a lamp do not all look like the lamp once tones are mapped. It takes light away there.
//
// Input:  multisampled colour, depth; BY_BRIGHTNESS: the exposure; VELOCITY: velocity, or AS_THE_EYE; sample_place, of each sample in
//         its pixel; COC: what include/coc_of_depth.glsl needs.
// Output: colour with alpha 1, gl_FragDepth; VELOCITY: velocity, px per frame; COC: finite colour, alpha
//         = signed CoC RADIUS in pixels of image width, negative in front of the focus. A half float
//         holds 11 px to 1/256 px. WITH_COVERAGE: its last bits are the part of the pixel that its surface covers
//         (include/coverage.glsl).
// Source: of the radius, Carnegie & Rhee 2015, Algorithm 1; PERIPHERAL: Hillaire et al. 2008, Eq. 5 and 6.
#include "eyes.glsl"
#ifdef VELOCITY
#include "view.glsl"
#include "velocity.glsl"
#endif
#ifdef COC
#include "coc.glsl"
#include "coc_of_depth.glsl"
#include "coverage.glsl"
#include "finite.glsl"
#endif
uniform sampler2DMS colors;
uniform sampler2DMS depths;
layout(location = 0) out vec4 color;
#ifdef WITH_COVERAGE
// How much farther, in radius, what is seen beside a pixel's surface is no part of it.
const float END_PX = 0.5, END_PART = 0.4;
#endif
#ifdef VELOCITY
uniform sampler2DMS velocities;
layout(location = 1) out vec2 velocity;
uniform vec2 sample_place[SAMPLES];

// Of a point of the world that does not move. In clip space w is 1: its distance is in the depth.
vec2 velocity_of_eye(vec2 at_px, float depth) {
    vec4 now = vec4(2.0 * at_px / image_size_px.xy - 1.0, depth, 1.0);
    return velocity_px(now, previous_clip_from_clip * now, image_size_px.xy);
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    float depth = -1.0;
    int nearest = 0;
#ifdef COC
    vec2 brightest = vec2(-1.0), nearest_light = vec2(0.0);  // light, depth
#endif
#ifdef WITH_COVERAGE
    float farthest = 2.0, places[SAMPLES];  // depths
#endif
    for (int i = 0; i < SAMPLES; ++i) {
        vec3 c = texelFetch(colors, pixel, i).rgb;
        float d = texelFetch(depths, pixel, i).r;
#ifdef COC
        vec2 light = vec2(max(c.r, max(c.g, c.b)), d);
        brightest = light.x > brightest.x ? light : brightest;
        nearest_light = d > depth ? light : nearest_light;
#endif
#ifdef BY_BRIGHTNESS
        float weight = 1.0 / (1.0 + BY_BRIGHTNESS * max(c.r, max(c.g, c.b)));
        c = weight * min(c, HALF_MAX);
        weights += weight;
#endif
        sum += c;
        nearest = d > depth ? i : nearest;
        depth = max(d, depth);
#ifdef WITH_COVERAGE
        farthest = min(d, farthest);
        places[i] = d;
#endif
    }
#ifdef BY_BRIGHTNESS
    color = vec4(sum / weights, 1.0);
#else
    color = vec4(sum * (1.0 / float(SAMPLES)), 1.0);
#endif
    gl_FragDepth = depth;
#ifdef COC
    vec2 at = gl_FragCoord.xy * (1.0 / vec2(textureSize(colors)));
    float lit = brightest.x > OUTSHINES * (1.0 + nearest_light.x) ? brightest.y : depth;
    color = vec4(finite(color.rgb), radius_at(lit, at));
#ifdef WITH_COVERAGE
    bool ends = lit == depth && radius_at(farthest, at) - color.a > END_PX + END_PART * abs(color.a);
    float between = 0.5 * (depth + farthest), covered = 0.0;
    for (int i = 0; i < SAMPLES; ++i)
        covered += places[i] >= between ? 1.0 / float(SAMPLES) : 0.0;
#ifdef BY_BRIGHTNESS
    covered = 1.0;  // colour is no mean by coverage
#endif
    color.a = with_coverage(color.a, ends ? covered : 1.0);
#endif
#endif
#ifdef VELOCITY
    velocity = texelFetch(velocities, pixel, nearest).rg;
    if (velocity.x == AS_THE_EYE)
        velocity = velocity_of_eye(vec2(pixel) + sample_place[nearest], depth);
#endif
}
