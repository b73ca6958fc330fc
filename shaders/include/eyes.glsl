// Images of one eye, or with EYES = 2 those of both, which are the layers of texture arrays and are drawn at
// once. What both eyes share (focus, noise) is a sampler2D.
//
// EYE: whose pixel it is. A vertex or compute shader defines it before it includes this file.
// A uniform of both eyes is an array of EYES.
#ifndef EYES
#define EYES 1
#endif
#if EYES > 1
#ifndef EYE
#define EYE gl_Layer
#endif
#define eye_image sampler2DArray
#define ueye_image usampler2DArray
#define stored_eye_image image2DArray
#define texel_of_eye(at) ivec3(at, EYE)
#define place_of_eye(uv) vec3(uv, EYE)
#define draw_in_layer() gl_Layer = EYE
#else
#undef EYE
#define EYE 0
#define eye_image sampler2D
#define ueye_image usampler2D
#define stored_eye_image image2D
#define texel_of_eye(at) (at)
#define place_of_eye(uv) (uv)
#define draw_in_layer()
#endif

#define texel_of(image, at) texelFetch(image, texel_of_eye(at), 0)
#define filtered_at(image, uv) textureLod(image, place_of_eye(uv), 0.0)
#define size_of(image) textureSize(image, 0).xy
