#version 450 core
// Makes one sample per pixel: colour is the mean, depth and velocity are those of one sample.
//
// A mean of depths lies on no surface, a mean of velocities moves nothing: both stay whole. The
// nearest sample is taken: a pixel on a silhouette then counts as foreground, whose blur it gets,
// and does not leave a line of the foreground's colour in the background's blur.
//
// Input:  multisampled colour, depth; VELOCITY: velocity.
// Output: colour with alpha 1, gl_FragDepth; VELOCITY: velocity.
layout(binding = 0) uniform sampler2DMS colors;
layout(binding = 1) uniform sampler2DMS depths;
layout(location = 0) out vec4 color;
#ifdef VELOCITY
layout(binding = 2) uniform sampler2DMS velocities;
layout(location = 1) out vec2 velocity;
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
    float depth = -1.0;
    int nearest = 0;
    for (int i = 0; i < SAMPLES; ++i) {
        sum += texelFetch(colors, pixel, i).rgb;
        float d = texelFetch(depths, pixel, i).r;
        nearest = d > depth ? i : nearest;
        depth = max(d, depth);
    }
    color = vec4(sum * (1.0 / float(SAMPLES)), 1.0);
    gl_FragDepth = depth;
#ifdef VELOCITY
    velocity = texelFetch(velocities, pixel, nearest).rg;
#endif
}
