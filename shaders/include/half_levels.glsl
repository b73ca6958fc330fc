// On which image a disc is summed by half_gather.frag and half_mean.frag: where it has up to 25 texels. Two
// images share the discs between them.
//
// TEXELS_PER_PX: the radius (px) of a disc, multiplied by it, is the side of these texels in those of the half
// image. LEVELS: how many images there are, of texels of 2, 4, … px.

// The part of a disc that is summed on this level.
float half_level_part(int level, float radius_px) {
    float wanted = log2(max(TEXELS_PER_PX * radius_px, 1e-3)) - float(level);
    float finest = level == 0 ? 1.0 : clamp(5.0 * wanted + 3.0, 0.0, 1.0);
    return finest - (level >= LEVELS - 1 ? 0.0 : clamp(5.0 * wanted - 2.0, 0.0, 1.0));
}

const float LEAST_NARROWED = 0.2;  // part of a disc's variance that is always left

// Part of the square of a texel that discs are wider by, beside what disc_texels takes back: with it a lamp's disc
// has its second moment (tests/render/effects/test_half_gather.py).
const float TEXEL_SHARE = 0.3;

// The radius that a disc is summed with, so that texels and enlargement do not widen it.
float narrowed_px(float radius_px, float texel_px) {
    float wider_px2 = ENLARGED_PX2 + TEXEL_SHARE * texel_px * texel_px;
    return sqrt(max(radius_px * radius_px - wider_px2, LEAST_NARROWED * radius_px * radius_px));
}
