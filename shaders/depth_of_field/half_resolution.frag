#version 450 core
// Half of an image, with the radius of what is blurred most in each 2x2 pixels.
//
// Input:  colour_and_coc of colour_and_coc.frag (signed CoC RADIUS, px of image width, negative in
//         front of the focus).
// Output: rgb = mean of the pixels that exist, a = the signed RADIUS of greatest magnitude, px of the
//         whole image. Size / 2, rounded up.
//
// FIREFLY: bright pixels weigh less, 1 / (1 + brightest channel), so that one alone does not flicker.
// NumPy twin: tests/oracles/half_resolution.py. As the prefilters of KinoBokeh and of Filament.
uniform sampler2D colour_and_coc;

out vec4 half_image;

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(colour_and_coc, 0) - 1;
    vec4 sum = vec4(0.0);
    float widest_px = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 pixel = first + ivec2(i & 1, i >> 1);
        if (any(greaterThan(pixel, last)))
            continue;
        vec4 p = texelFetch(colour_and_coc, pixel, 0);
#ifdef FIREFLY
        float weight = 1.0 / (1.0 + max(p.r, max(p.g, p.b)));
#else
        float weight = 1.0;
#endif
        sum += weight * vec4(p.rgb, 1.0);
        widest_px = abs(p.a) > abs(widest_px) ? p.a : widest_px;
    }
    half_image = vec4(min(sum.rgb / sum.a, 65504.0), widest_px);
}
