// The light that comes to a place from all texels of LEVEL px around: of the background, or
// (FOREGROUND) of the foreground.
//
// The discs are the grid's (disc_share): no tap lies between them, the sum over a disc is its light. Radii
// are signed where they are called so, in pixels of image width. Include after coarse.glsl.

#ifdef FOREGROUND
uniform sampler2D coarse_foreground;  // coarse_foreground.frag

// What is so many texels away and nearer than a surface, as opacity.
vec4 light_of(ivec2 there, float away, float signed_px) {
    ivec2 last_coarse = textureSize(coarse_foreground, 0) - 1;
    vec4 q = texelFetch(coarse_foreground, clamp(there, ivec2(0), last_coarse), 0);
    vec2 foreground = unpacked_foreground(q.a);
    float over = foreground.y * nearer(signed_px, foreground.x) / (PI * pixel_aspect);
    return over * disc_share(away, grid_radius_px(disc_texels(abs(foreground.x)))) * vec4(q.rgb, 1.0);
}
#else
uniform sampler2D coarse_colour_and_coc;  // coc_downsample_tent.frag

// What is so many texels away and not nearer than a surface, as weight.
vec4 light_of(ivec2 there, float away, float signed_px) {
    ivec2 last_coarse = textureSize(coarse_colour_and_coc, 0) - 1;
    vec4 q = texelFetch(coarse_colour_and_coc, clamp(there, ivec2(0), last_coarse), 0);
    float share = disc_share(away, grid_radius_px(disc_texels(abs(signed_px))));
    return (1.0 - nearer(signed_px, q.a)) * share * vec4(q.rgb, 1.0);
}
#endif

// What comes from a disc of this radius around a place (in texels, 0 is the middle of the first), which may
// lie between texels; nothing unless wanted.
vec4 sum_over(bool wanted, vec2 place, float signed_px, float radius_px) {
    vec4 sum = vec4(0.0);
    float most = wanted ? grid_radius_px(disc_texels(radius_px)) + 0.5 * RIM_PX : -1.0;
    float rows = most * pixel_aspect;
    int top = int(floor(place.y + rows));
    for (int y = int(ceil(place.y - rows)); y <= top; ++y) {
        float row = (float(y) - place.y) / pixel_aspect;
        float cells = sqrt(max(most * most - row * row, 0.0));
        int right = int(floor(place.x + cells));
        for (int x = int(ceil(place.x - cells)); x <= right; ++x)
            sum += light_of(ivec2(x, y), length(vec2(float(x) - place.x, row)), signed_px);
    }
    return sum;
}
