// Reads an image between its texels by a cubic through them: five bilinear reads, no blur of its own.
//
// Catmull & Rom, "A class of local interpolating splines", 1974; the four corners, which weigh half a percent
// at most, are left out. Include after footprint.glsl.

vec3 cubic(sampler2D image, vec2 at) {
    vec2 size = vec2(textureSize(image, 0));
    vec2 first = floor(at * size - 0.5), f = at * size - 0.5 - first;
    vec2 before = f * (-0.5 + f * (1.0 - 0.5 * f)), after = f * f * (-0.5 + 0.5 * f);
    vec2 second = 0.5 * f + f * f * (2.0 - 1.5 * f);
    vec2 between = 1.0 - before - after;  // of the two texels around
    vec2 middle = (first + 0.5 + second / between) / size;
    vec2 left = (first - 0.5) / size, right = (first + 2.5) / size;
    vec4 sum = between.x * between.y * vec4(textureLod(image, middle, 0.0).rgb, 1.0);
    sum += before.x * between.y * vec4(textureLod(image, vec2(left.x, middle.y), 0.0).rgb, 1.0);
    sum += after.x * between.y * vec4(textureLod(image, vec2(right.x, middle.y), 0.0).rgb, 1.0);
    sum += before.y * between.x * vec4(textureLod(image, vec2(middle.x, left.y), 0.0).rgb, 1.0);
    sum += after.y * between.x * vec4(textureLod(image, vec2(middle.x, right.y), 0.0).rgb, 1.0);
    return clamp(UP * sum.rgb / sum.a, 0.0, 65504.0);
}
