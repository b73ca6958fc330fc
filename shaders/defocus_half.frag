#version 450 core
// Half resolution for the widest discs, where taps lie further apart than two pixels.
//
// Input:  points of defocus.frag. Output: rgb, a as there, at half size (rounded up).
//
// Only pixels that are about as blurred as the most blurred of the four are averaged: a sharp
// pixel never gets into a blurred one, which is what keeps sharp silhouettes from bleeding.
uniform sampler2D points;

out vec4 point;

void main() {
    ivec2 last = textureSize(points, 0) - 1;
    ivec2 corner = ivec2(gl_FragCoord.xy) * 2;
    vec4 p[4];
    float radius = 0.0;
    for (int i = 0; i < 4; ++i) {
        p[i] = texelFetch(points, min(corner + ivec2(i & 1, i >> 1), last), 0);
        radius = abs(p[i].a) > abs(radius) ? p[i].a : radius;
    }
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        float like = max(1.0 - abs(p[i].a - radius), 0.0);
        sum += like * vec4(p[i].rgb, 1.0);
    }
    point = vec4(sum.rgb / sum.a, radius);  // the most blurred pixel itself has weight 1
}
