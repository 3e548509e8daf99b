/* ArmSkin: vertices of a mesh that is no stack of rings, each with a weight of its own. */
#ifndef ARM_SKIN_VERTICES_H
#define ARM_SKIN_VERTICES_H

#include "motion.h"
#include "mesh.h"

#include <float.h>

INLINED Float3 row3(const ArmMesh *mesh, VertexRow first, size_t i)
{
    Float3 v = {mesh->vertex_row[first][i], mesh->vertex_row[first + 1][i], mesh->vertex_row[first + 2][i]};
    return v;
}

/* The twist along the forearm at a vertex: how far it turns there, and how fast along the bone. */
typedef struct Twist {
    float sine, cosine, slope;
} Twist;

/* By signs, since compilers keep comparisons of numbers that may not be numbers out of vectors: the
 * share is s between 0 and 1, 0 before and 1 after, and its slope 1 between. */
INLINED Twist twist_at(const SkinMotion *motion, float x)
{
    float share = (x - motion->spread_begin) * motion->spread_slope;
    float within = 0.5f * (fabsf(share) - fabsf(share - 1.0f) + 1.0f);
    float inside = 0.5f * (copysignf(1.0f, share) - copysignf(1.0f, share - 1.0f));
    Twist twist;
    twist.slope = inside * motion->spread * motion->spread_slope;
    sine_and_cosine(motion->spread * within, &twist.sine, &twist.cosine);
    return twist;
}

INLINED Float3 twisted_about_bone(Twist twist, Float3 v)
{
    Float3 f = {v.x, twist.cosine * v.y - twist.sine * v.z, twist.sine * v.y + twist.cosine * v.z};
    return f;
}

/* A normal or a gradient at `point`: by the cofactors of the twist's Jacobian, of determinant 1. */
INLINED Float3 twisted_normal(Twist twist, Float3 point, Float3 n)
{
    n.x -= twist.slope * (point.y * n.z - point.z * n.y);
    return twisted_about_bone(twist, n);
}

/* The point within its section: made wider, and drawn in. */
INLINED Float3 in_section(int method, const SkinMotion *motion, float width, float inward, Float3 v)
{
    Float3 wider = {v.x, width * v.y, width * v.z};
    return method == ARM_SKIN_METHOD_COMPENSATED ? plus_scaled(wider, inward, motion->inward) : v;
}

/* -(p K + q Q) c: what the centre of rotation adds. */
INLINED Float3 center_shift(const SkinMotion *motion, float first, float second, Float3 center)
{
    return plus_scaled(times(-first, carried(motion->first, center)), -second, carried(motion->second, center));
}

INLINED Float3 vertex_place(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh, size_t i)
{
    float w = mesh->vertex_row[VERTEX_WEIGHT][i];
    Float3 point = row3(mesh, VERTEX_X, i);
    Share at = shares_at(method, motion, wound, w).at;
    Matrix3 m = share_matrix(motion, &at, w);
    if (twisted) {
        point = twisted_about_bone(twist_at(motion, point.x), point);
    }
    Float3 place = carried(m, in_section(method, motion, at.width, at.inward, point));
    if (method == ARM_SKIN_METHOD_CENTER_OF_ROTATION) {
        place = plus_scaled(place, 1.0f, center_shift(motion, at.first, at.second, row3(mesh, VERTEX_CENTER_X, i)));
    }
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        place = plus_scaled(place, at.slide, motion->slide);
    }
    place = plus_scaled(plus_scaled(place, at.gap, motion->gap), 1.0f, motion->rest_of_shift);
    return plus_scaled(place, 1.0f, motion->shift);
}

/* J = M + u g^T: cof(J) n = cof(M) n + M (g x n) x u. */
INLINED Float3 vertex_normal(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh, size_t i)
{
    float w = mesh->vertex_row[VERTEX_WEIGHT][i];
    Float3 point = row3(mesh, VERTEX_X, i);
    Float3 normal = row3(mesh, VERTEX_NORMAL_X, i);
    Float3 gradient = row3(mesh, VERTEX_GRADIENT_X, i);
    if (twisted) {
        Twist twist = twist_at(motion, point.x);
        normal = twisted_normal(twist, point, normal);
        gradient = twisted_normal(twist, point, gradient);
        point = twisted_about_bone(twist, point);
    }
    Shares shares = shares_at(method, motion, wound, w);
    Share at = shares.at, rate = shares.rate;
    Matrix3 m = share_matrix(motion, &at, w);
    Float3 u = carried(share_matrix_rate(motion, &rate), in_section(method, motion, at.width, at.inward, point));
    if (method == ARM_SKIN_METHOD_CENTER_OF_ROTATION) {
        u = plus_scaled(u, 1.0f, center_shift(motion, rate.first, rate.second, row3(mesh, VERTEX_CENTER_X, i)));
        u = plus_scaled(u, 1.0f, center_shift(motion, at.first, at.second, row3(mesh, VERTEX_CENTER_RATE_X, i)));
    }
    if (method == ARM_SKIN_METHOD_COMPENSATED) {
        Float3 moved = {0.0f, rate.width * point.y, rate.width * point.z};
        u = plus_scaled(u, 1.0f, carried(m, plus_scaled(moved, rate.inward, motion->inward)));
        m.y = times(at.width, m.y);
        m.z = times(at.width, m.z);
    }
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        u = plus_scaled(u, rate.slide, motion->slide);
    }
    u = plus_scaled(u, rate.gap, motion->gap);
    Float3 turned;
    if (method == ARM_SKIN_METHOD_LINEAR_BLEND) {
        Matrix3 cofactors = {across(m.y, m.z), across(m.z, m.x), across(m.x, m.y)};
        turned = carried(cofactors, normal);
    } else {
        Float3 wider = {at.width * at.width * normal.x, normal.y, normal.z};
        turned = carried(m, wider);
    }
    Float3 n = plus_scaled(turned, 1.0f, across(carried(m, across(gradient, normal)), u));
    return times(1.0f / sqrtf(n.x * n.x + n.y * n.y + n.z * n.z + FLT_MIN), n);
}

INLINED void each_vertex(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                         float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t i = 0; i < n; i++) {
        Float3 place = vertex_place(method, motion, wound, twisted, mesh, i);
        out[i] = place.x;
        out[n + i] = place.y;
        out[2 * n + i] = place.z;
    }
}

INLINED void each_normal(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                         float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t i = 0; i < n; i++) {
        Float3 normal = vertex_normal(method, motion, wound, twisted, mesh, i);
        out[i] = normal.x;
        out[n + i] = normal.y;
        out[2 * n + i] = normal.z;
    }
}

#endif
