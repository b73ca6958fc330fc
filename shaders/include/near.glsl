// What is drawn over a picture of its own of what lies behind it: things in front of the focus.
//
// RADIUS in pixels of image width, negative in front of the focus.
//
// The picture behind ends where the radius is BEHIND_PX, and there shows what lies behind. A surface that goes on
// is continued over that end by what is near. Nothing of it spreads from there: a silhouette whose radius is
// less would be blurred in both.

const float NEAR_PX = 0.5;    // what is blurred less is sharp: no surface is continued in it
// At 2.5 px the error of rims was larger (python -m bench.blur --set samples=36 --rounds 1). Narrower discs are
// too wide at half resolution.
#ifndef BEHIND_PX
const float BEHIND_PX = 2.0;  // what is blurred more, in front of the focus, is not in the picture behind
#endif
const float FADES_PX = 0.1;    // of radius, in which a surface is taken over

// Part of a pixel that is near, or may continue what is.
float near_part(float radius_px) {
    return clamp((-radius_px - NEAR_PX) / FADES_PX, 0.0, 1.0);
}

// Part of it that the picture behind lacks.
float apart(float radius_px) {
    return clamp((-radius_px - BEHIND_PX) / FADES_PX + 1.0, 0.0, 1.0);
}

// Small discs are summed over pixels (near_pixels.frag): texels of half the image are as wide, and make stairs of edges.
const float PIXELS_PX = 4.0;         // of what is blurred more, none are
const float FROM_PIXELS_PX = 3.4;    // of what is blurred less, all: about as levels share discs (levels.glsl)

// Part of a disc that is.
float pixels_part(float radius_px) {
    float part = clamp((PIXELS_PX + radius_px) / (PIXELS_PX - FROM_PIXELS_PX), 0.0, 1.0);
    return BEHIND_PX < PIXELS_PX ? part : 0.0;
}

// Of the steps of a radius to both sides, the lesser; 0 where a surface ends at both.
float lesser(float a, float b) {
    float found = abs(a) < abs(b) ? a : b;
    return abs(found) < 0.5 ? found : 0.0;
}

// Opacity adds up to 1 at most.
vec4 limited(vec4 sum) {
    return sum / max(sum.a, 1.0);
}

vec4 upon(vec4 front, vec4 back) {
    return front + (1.0 - front.a) * back;
}

// What is seen past the front, and not through it.
vec4 past(vec4 front, vec4 back) {
    return front + min(1.0, (1.0 - front.a) / max(back.a, 1e-4)) * back;
}

// From which RADIUS on what is behind a surface lies well behind it, and does not go on from it.
float well_behind_px(float radius_px) {
    return 0.75 * radius_px + 0.5;
}

// 0 up to there, 1 as far again behind it.
float farther(float own, float q) {
    return clamp((q - own) / (well_behind_px(own) - own) - 1.0, 0.0, 1.0);
}
