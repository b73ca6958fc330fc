/* Poses: a rotation (x, y, z, w), then a translation in metres. */

#include "runtime.h"

#include <math.h>

const Pose IDENTITY = {{0, 0, 0}, {0, 0, 0, 1}};

Pose pose_of(const XrPosef *pose) {
    const XrVector3f *p = &pose->position;
    const XrQuaternionf *q = &pose->orientation;
    return (Pose){{p->x, p->y, p->z}, {q->x, q->y, q->z, q->w}};
}

XrPosef pose_to_xr(const Pose *pose) {
    const double *p = pose->p, *q = pose->q;
    return (XrPosef){
        {(float)q[0], (float)q[1], (float)q[2], (float)q[3]},
        {(float)p[0], (float)p[1], (float)p[2]},
    };
}

static void turn(const double q[4], const double v[3], double out[3]) {
    double t[3]; /* v + 2 w (u × v) + 2 u × (u × v), with u the vector part of q */
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        t[i] = 2 * (q[j] * v[k] - q[k] * v[j]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i] = v[i] + q[3] * t[i] + q[j] * t[k] - q[k] * t[j];
    }
}

Pose pose_times(const Pose *a, const Pose *b) {
    Pose c;
    turn(a->q, b->p, c.p);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        c.p[i] += a->p[i];
        c.q[i] = a->q[3] * b->q[i] + a->q[i] * b->q[3] + a->q[j] * b->q[k] - a->q[k] * b->q[j];
    }
    c.q[3] = a->q[3] * b->q[3] - a->q[0] * b->q[0] - a->q[1] * b->q[1] - a->q[2] * b->q[2];
    return c;
}

Pose pose_inverse(const Pose *pose) {
    const double *q = pose->q;
    Pose inverse = {{0}, {-q[0], -q[1], -q[2], q[3]}};
    double back[3] = {-pose->p[0], -pose->p[1], -pose->p[2]};
    turn(inverse.q, back, inverse.p);
    return inverse;
}

bool pose_is_valid(const XrPosef *pose) {
    const XrQuaternionf *q = &pose->orientation;
    double square = q->x * q->x + q->y * q->y + q->z * q->z + q->w * q->w;
    return fabs(square - 1) < 0.02 && isfinite(pose->position.x) && isfinite(pose->position.y) &&
           isfinite(pose->position.z);
}
