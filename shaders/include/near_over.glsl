// The discs of near things in a pixel: between texels of half the image (near_gather.frag), and small ones of pixels
// (near_pixels.frag). Include after near.glsl.
//
// Where one is brighter than white, the mean of a texel's pixels stays about what the texel is, so that
// a lamp's disc has no rim beyond its own. They are multiplied: a difference would be more than all of some.

const float LEAST_MEAN = 1e-6;
const float KEPT = 0.8;  // with 1, small discs are white 0.3 px less far than they should be (test_near_things.py)

vec4 near_texel(eye_image near, ivec2 at) {
    return texel_of(near, clamp(at, ivec2(0), size_of(near) - 1));
}

vec4 near_half(eye_image near, ivec2 pixel) {
    ivec2 middle = pixel / 2, side = 2 * (pixel & 1) - 1;
    vec4 own = near_texel(near, middle);
    vec4 others[3] = vec4[3](near_texel(near, middle + ivec2(side.x, 0)), near_texel(near, middle + ivec2(0, side.y)),
                             near_texel(near, middle + side));
    vec4 over = 0.75 * 0.75 * own + 0.75 * 0.25 * (others[0] + others[1]) + 0.25 * 0.25 * others[2];  // bilinear
    vec4 most = max(max(own, others[0]), max(others[1], others[2]));
    float part = clamp(max(max(most.r, most.g), most.b) - 1.0, 0.0, 1.0);
    int around = part > 0.0 ? 1 : -1;
    vec4 mean = vec4(0.0);  // over the texel, of what is bilinear
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x)
            mean += (x == 0 ? 0.75 : 0.5 * 0.25) * (y == 0 ? 0.75 : 0.5 * 0.25) * near_texel(near, middle + ivec2(x, y));
    vec4 kept = pow(own / max(mean, LEAST_MEAN), vec4(KEPT * part));
    return part > 0.0 ? min(over * kept, most) : over;
}

// Wider discs are nearer; of two of one surface, each has what the other leaves.
vec4 near_over(eye_image near, eye_image near_pixels, ivec2 pixel) {
    return past(near_half(near, pixel), texel_of(near_pixels, pixel));
}
