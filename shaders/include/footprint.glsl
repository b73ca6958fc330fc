// The mean over a disc of one surface, by reads of 2 x 2 texels each: every texel counts once.
//
// Radii in texels of what is read. BLOCKS pairs of opposite reads, outwards: x and y of one from the middle
// of the disc's texel, how far that is, and by which part of it a read moves inwards where none of it
// is inside the rim. WIDEST: radius that they cover; wider discs spread them. Include after discs.glsl.
// Twin: tests/oracles/disc_footprint.py.

uniform vec4 blocks[BLOCKS];
uniform int block_count;  // BLOCKS, which compilers must not know: unrolled loops do not end early

// `at`: of the disc's middle, in texture coordinates. `wanted`: whether anything is to be read.
vec3 mean_over(sampler2D image, vec2 at, vec3 own, float radius, bool wanted) {
    vec2 per_texel = 1.0 / vec2(textureSize(image, 0));
    float spread = max(radius / WIDEST, 1.0);
    float lod = log2(spread);
    float covered = radius / spread - NARROWER;
    float beyond = wanted ? (covered + 1.0) * max(pixel_aspect, 1.0) : 0.0;
    vec2 square = vec2(1.0, 1.0 / pixel_aspect);
    float weight = disc_weight(0.0, covered, 2.0);
    vec4 sum = vec4(own, 1.0) * weight;
    for (int i = 0; i < block_count && blocks[i].z < beyond; ++i) {
        weight = disc_weight(length(blocks[i].xy * square), covered, 2.0);
        vec2 away = spread * (1.0 - blocks[i].w * (1.0 - weight)) * blocks[i].xy * per_texel;
        vec3 two = textureLod(image, at + away, lod).rgb + textureLod(image, at - away, lod).rgb;
        sum += 4.0 * weight * vec4(two, 2.0);
    }
    return min(sum.rgb / max(sum.a, 1e-4), 65504.0);
}
