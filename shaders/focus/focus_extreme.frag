#version 450 core
// Down-samples by two: of 2 x 2 candidates, the nearest (FARTHEST: the farthest) that comes first.
//
// Input:  source: x = near_m / distance, y = 1 for those that come first (focus_candidates.frag).
// Output: the same of half the size, rounded up. Repeated down to one texel it holds that of all.
// Twin:   vrcomfort/optics/autofocus_zone.py.
// Source: Hillaire et al. 2008, "The autofocus zone".
uniform sampler2D source;
out vec4 found;

bool is_before(vec2 a, vec2 b) {
    if (a.y != b.y) return a.y > b.y;
#ifdef FARTHEST
    return a.x < b.x;
#else
    return a.x > b.x;
#endif
}

void main() {
    ivec2 size = textureSize(source, 0);
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    vec2 best = vec2(0.0, -1.0);  // comes after all
    for (int y = first.y; y < min(first.y + 2, size.y); ++y)
        for (int x = first.x; x < min(first.x + 2, size.x); ++x) {
            vec2 other = texelFetch(source, ivec2(x, y), 0).xy;
            if (is_before(other, best)) best = other;
        }
    found = vec4(best, 0.0, 0.0);
}
