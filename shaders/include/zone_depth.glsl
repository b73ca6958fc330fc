// How far what a pixel of the autofocus zone shows is: near_m over its distance.
//
// Input:  depth of the zone from the head centre: reverse-Z, near_m / distance along the head's
//         forward axis, 0 = sky. ALONG_RAY: half_tangents, half width and half height of the zone;
//         centre, tangents of its middle.
// Output: near_m / distance, at least that of infinity_m; ALONG_RAY: distance along the pixel's ray.
// Twin:   vrcomfort/optics/autofocus_zone.py.
uniform sampler2D depth;
uniform float near_m;
uniform float infinity_m;
#ifdef ALONG_RAY
uniform vec2 half_tangents;
uniform vec2 centre;
#endif

// uv: position in the zone, in [0, 1].
float zone_depth(ivec2 pixel, vec2 uv) {
    float z = texelFetch(depth, pixel, 0).r;
#ifdef ALONG_RAY
    z /= length(vec3(centre + (2.0 * uv - 1.0) * half_tangents, 1.0));
#endif
    return max(z, near_m / infinity_m);
}
