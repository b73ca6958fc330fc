#version 450 core
// How wide the discs of a tile are, in front of the focus and behind it.
//
// Input:  half_image of half_resolution.frag (signed CoC RADIUS, px of the whole image, negative in
//         front of the focus). With DILATE: tiles of this shader.
// Output: r = largest RADIUS in front, positive, g = largest behind; a texel is TILE x TILE texels.
//         With DILATE: of the 3x3 tiles around.
// NumPy twin: tests/oracles/half_resolution.py. As the tiles of Filament's depth of field.
uniform sampler2D source;

out vec2 widest_px;

void main() {
    ivec2 last = textureSize(source, 0) - 1;
    widest_px = vec2(0.0);
#ifdef DILATE
    for (int i = 0; i < 9; ++i) {
        ivec2 tile = ivec2(gl_FragCoord.xy) + ivec2(i % 3, i / 3) - 1;
        widest_px = max(widest_px, texelFetch(source, clamp(tile, ivec2(0), last), 0).rg);
    }
#else
    for (int i = 0; i < TILE * TILE; ++i) {
        ivec2 texel = TILE * ivec2(gl_FragCoord.xy) + ivec2(i % TILE, i / TILE);
        float radius_px = texelFetch(source, min(texel, last), 0).a;
        widest_px = max(widest_px, vec2(-radius_px, radius_px));
    }
#endif
}
