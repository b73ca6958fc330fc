// Radiance of the sky at infinity, by direction (unit, world axes). Needs light.glsl.
//
//          zenith
//        . - ~ - .
//      .   clouds  .        clouds lie on a plane overhead, drawn at infinity
//     |  o sun      |
//   --+-- horizon --+--
//     '   ground    '

const float SUN_COS = 0.99998892;      // cosine of the sun's angular radius, 0.27 degrees
const float SUN_SOLID_ANGLE = 6.96e-5; // steradians: radiance = irradiance / solid angle

float hash(vec2 cell) {
    // Integer hash (Jarzynski & Olano, JCGT 2020, "pcg"): the same bits on every machine.
    uvec2 v = uvec2(ivec2(cell) + 32768);
    uint state = (v.x * 1664525u + v.y * 22695477u) * 747796405u + 2891336453u;
    state = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return float((state >> 22u) ^ state) * (1.0 / 4294967296.0);
}

float value_noise(vec2 p) {
    vec2 cell = floor(p);
    vec2 f = p - cell;
    f = f * f * (3.0 - 2.0 * f);
    vec2 near = vec2(hash(cell), hash(cell + vec2(1.0, 0.0)));
    vec2 far = vec2(hash(cell + vec2(0.0, 1.0)), hash(cell + vec2(1.0, 1.0)));
    vec2 row = mix(near, far, f.y);
    return mix(row.x, row.y, f.x);
}

// Share of light that clouds take, 0 to 1, at a direction above the horizon.
float cloud_density(vec3 direction, float cover) {
    vec2 p = direction.xz * (2.2 / (direction.y + 0.12)) + vec2(3.7, 1.3);
    float sum = 0.0;
    float weight = 0.5;
    for (int octave = 0; octave < 5; ++octave) {
        sum += weight * value_noise(p);
        p = mat2(1.6, 1.2, -1.2, 1.6) * p;  // turn by 37 degrees and double: hides the lattice
        weight *= 0.5;
    }
    return smoothstep(1.0 - cover, 1.35 - cover, sum * 1.1);
}

// Gradient only: what reflects in rough surfaces.
vec3 sky_gradient(vec3 direction) {
    // A unit vector may be rounded to be longer: the power of a negative number is undefined.
    float thickness = pow(clamp(1.0 - direction.y, 0.0, 1.0), 4.0);
    vec3 above = mix(sky_zenith.rgb, sky_horizon.rgb, thickness);
    return mix(above, ground.rgb, smoothstep(0.0, 0.12, -direction.y));
}

vec3 sky_radiance(vec3 direction) {
    float to_sun = max(dot(direction, sun_direction.xyz), 0.0);
    vec3 radiance = sky_gradient(direction);
    // Forward scattering around the sun (Mie), two lobes chosen by eye.
    float glow = 0.10 * pow(to_sun, 12.0) + 0.5 * pow(to_sun, 320.0);
    radiance += sun_irradiance.rgb * glow * 0.3;
    float disc = smoothstep(SUN_COS, SUN_COS + 4e-6, to_sun);
#ifdef CLOUDS
    float up = max(direction.y, 0.0);
    float density = cloud_density(vec3(direction.x, up, direction.z), clouds.x);
    vec3 lit = sun_irradiance.rgb * (0.22 + 0.25 * pow(to_sun, 6.0)) + 0.6 * sky_zenith.rgb;
    vec3 cloud = mix(lit, 0.55 * lit, density * density);
    float opacity = density * smoothstep(0.0, 0.25, up) * 0.92;
    radiance = mix(radiance, cloud, opacity);
    disc *= 1.0 - opacity;
#endif
    radiance += disc * min(sun_irradiance.rgb / SUN_SOLID_ANGLE, vec3(60000.0));
    return radiance;
}
