#version 450 core
// Rings of samples at half resolution, once for the background and once for the foreground.
//
// Input:  half_image of half_resolution.frag (signed CoC RADIUS, px of the whole image, negative in
//         front of the focus), levels of mip_downsample.frag above it (read bilinearly), tiles of
//         half_resolution_tiles.frag, dilated.
// Output: background: rgb of what is at the focus or behind it, in the pixel's own disc;
//         foreground: rgb of the foreground, in the tile's widest disc, a = its opacity.
//
//      . . . .          8 k samples on ring k; each is read from the level whose texels are about as
//     . . . . .         wide as the gaps between samples
//      . . . .
//
// NumPy twin: tests/oracles/half_resolution.py. As the gather of Filament's depth of field (Abdallah
// and Guy, after Jimenez 2014), with 5 rings, the centre among them.
uniform sampler2D half_image;
uniform sampler2D levels[CHAIN];
uniform sampler2D tiles;
uniform float pixel_aspect;   // image pixels per unit, vertical / horizontal

layout(location = 0) out vec4 background;
layout(location = 1) out vec4 foreground;

const float TURN = 6.28318531;

vec3 colour_at(vec2 texels, int level) {
    vec3 colour = vec3(0.0);
    if (level == 0)
        colour = textureLod(half_image, texels / vec2(textureSize(half_image, 0)), 0.0).rgb;
    // Samplers in an array may be chosen by nothing that differs between pixels.
    for (int k = 1; k <= CHAIN; ++k)
        if (k == level)
            colour = textureLod(levels[k - 1], texels / exp2(float(k)) / vec2(textureSize(levels[k - 1], 0)), 0.0).rgb;
    return colour;
}

// The level whose texels fill the gaps between samples of a disc.
int level_of(float radius_px) {
    float gap_texels = 0.5 * radius_px / float(RINGS - 1);
    return clamp(int(round(log2(max(gap_texels, 1.0)))), 0, CHAIN);
}

void main() {
    vec2 size = vec2(textureSize(half_image, 0));
    vec4 centre = texelFetch(half_image, ivec2(gl_FragCoord.xy), 0);
    float front_px = texelFetch(tiles, ivec2(gl_FragCoord.xy) / TILE, 0).r;
    vec2 reach_px = vec2(max(centre.a, 0.0), front_px);
    vec4 behind = vec4(centre.rgb, 1.0), front = vec4(0.0);
    float share_px2 = front_px * front_px / float(1 + 4 * RINGS * (RINGS - 1));
    for (int side = 0; side < 2; ++side) {
        if (reach_px[side] < 1.0)
            continue;
        int level = level_of(reach_px[side]);
        for (int ring = side == 0 ? 1 : 0; ring < RINGS; ++ring) {
            float distance_px = reach_px[side] * float(ring) / float(RINGS - 1);
            int count = max(8 * ring, 1);
            for (int i = 0; i < count; ++i) {
                float angle = TURN * (float(i) + 0.5 * float(ring & 1)) / float(count);
                vec2 away_px = distance_px * vec2(cos(angle), sin(angle)) * vec2(1.0, pixel_aspect);
                vec2 texels = gl_FragCoord.xy + 0.5 * away_px;
                float tap_px = textureLod(half_image, texels / size, 0.0).a;
                float own_px = side == 0 ? tap_px : -tap_px;
                float covers = clamp(own_px - distance_px + 1.0, 0.0, 1.0) * step(0.5, own_px);
                if (covers <= 0.0)
                    continue;
                vec4 share = covers * vec4(colour_at(texels, level), 1.0);
                if (side == 0)
                    behind += share;
                else
                    front += share * share_px2 / max(tap_px * tap_px, 1.0);
            }
        }
    }
    background = vec4(min(behind.rgb / behind.a, 65504.0), 1.0);
    vec3 colour = front.a > 0.0 ? front.rgb / front.a : background.rgb;
    foreground = vec4(min(colour, 65504.0), clamp(front.a, 0.0, 1.0));
}
