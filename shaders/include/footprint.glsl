// The mean over a disc of one surface: every texel that it covers counts once.
//
// Radii in texels of the IMAGE that is read, by colour_of(image, texel). Include after discs.glsl and finite.glsl.

// `place`: of the disc's middle, 0 is that of the first texel. `wanted`: whether anything is to be read.
vec3 mean_over(IMAGE image, vec2 place, float radius, bool wanted) {
    float grid = grid_radius_px(max(radius, 0.5));
    float reach = grid + 0.5 * RIM_PX;
    float rows = reach * pixel_aspect;
    int top = wanted ? int(floor(place.y + rows)) : -1000000;
    ivec2 last = size_of(image) - 1;
    vec4 sum = vec4(0.0);
    for (int y = int(ceil(place.y - rows)); y <= top; ++y) {
        float row = (float(y) - place.y) / pixel_aspect;
        float cells = sqrt(max(reach * reach - row * row, 0.0));
        int right = int(floor(place.x + cells));
        for (int x = int(ceil(place.x - cells)); x <= right; ++x) {
            float inside = clamp((grid - length(vec2(float(x) - place.x, row))) / RIM_PX + 0.5, 0.0, 1.0);
            float weight = inside * inside * (3.0 - 2.0 * inside);
            sum += weight * vec4(colour_of(image, clamp(ivec2(x, y), ivec2(0), last)), 1.0);
        }
    }
    return min(UP * sum.rgb / max(sum.a, 1e-4), HALF_MAX);
}
