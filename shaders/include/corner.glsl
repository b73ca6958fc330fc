// A corner of a triangle that covers an eye's image, or with CORNERS of those that cover a part of it, in
// [0, 1]. Of each eye three vertices, or those that say so themselves. Before eyes.glsl EYE is `eye`.
#ifdef CORNERS
in vec3 corner_of_eye;  // z: whose it is
vec2 corner = corner_of_eye.xy;
int eye = int(corner_of_eye.z);
#else
int eye = gl_VertexID / 3;
vec2 corner = vec2((gl_VertexID % 3 << 1) & 2, gl_VertexID % 3 & 2);
#endif
