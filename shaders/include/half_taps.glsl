// Small discs from taps in the pixels, and how they go over into half an image.
//
// SMALL_FROM_PX, SMALL_PX: between these radii a pixel goes from one to the other. Include after coc.glsl and
// half_gathered.glsl. TAPS: on a ring; COUNTS(q): weight of one.

const float SOME = 0.01, ALL = 0.99;  // of the four texels
const float READ_PX2 = 0.3;  // what bilinear reads add to the square of a radius

// Part of a pixel that is what was gathered. `wide`: that by its radius. Beside what only covers, taps in the
// pixels are better than the few texels that are complete.
float gathered_part(Gathered soft, float wide) {
    return soft.part > ALL ? wide + soft.complete.a - wide * soft.complete.a
         : wide < 1.0 ? wide * soft.part * soft.part : soft.part > SOME ? 1.0 : 0.0;
}

const float TURN_BY = 2.0 * PI / float(TAPS);
const mat2 TURN = mat2(cos(TURN_BY), sin(TURN_BY), -sin(TURN_BY), cos(TURN_BY));

// The first tap on the ring of a disc; its centre and the ring have the second moment of a disc.
vec2 first_tap(float radius_px) {
    const float FIRST = TURN_BY * (TAPS % 2 == 0 ? 0.5 : 0.125);  // none along an axis
    const float RING = sqrt(0.5 + 0.5 / float(TAPS));
    return RING * sqrt(max(radius_px * radius_px - READ_PX2, 0.0)) * vec2(cos(FIRST), sin(FIRST));
}

// The mean over the disc of p.
vec3 mean_of_taps(vec4 p, bool wanted) {
    vec2 size = vec2(size_of(colour_and_coc));
    vec2 away = first_tap(p.a);
    vec4 sum = vec4(p.rgb, 1.0);
    int taps = wanted ? TAPS : 0;
    for (int i = 0; i < taps; ++i) {
        vec4 q = filtered_at(colour_and_coc, (gl_FragCoord.xy + away * vec2(1.0, pixel_aspect)) / size);
        sum += COUNTS(q) * vec4(q.rgb, 1.0);
        away = TURN * away;
    }
    return wanted ? sum.rgb / sum.a : p.rgb;
}
