#version 450 core
// Half of half an image, and so on: mean colour, foremost radius.
//
// Input:  source: half_image of half_resolution.frag, or a level of this shader.
// Output: rgb = mean of the texels that exist; a = least signed RADIUS, px of the whole image. Size / 2,
//         rounded up.
// NumPy twin: tests/oracles/half_resolution.py. As the mip levels of Filament's depth of field.
uniform sampler2D source;

out vec4 halved;

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy), last = textureSize(source, 0) - 1;
    vec4 sum = vec4(0.0);
    float least_px = 65504.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 texel = first + ivec2(i & 1, i >> 1);
        if (any(greaterThan(texel, last)))
            continue;
        vec4 t = texelFetch(source, texel, 0);
        sum += vec4(t.rgb, 1.0);
        least_px = min(least_px, t.a);
    }
    halved = vec4(sum.rgb / sum.a, least_px);
}
