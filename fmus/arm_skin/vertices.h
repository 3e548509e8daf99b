/* ArmSkin: vertices of a mesh that is no stack of rings, each with a weight of its own.
 *
 * In the hinge's axes, the first along the turn and the others across it, every method's map at a
 * weight is a complex number z for the two across: |z| = 1 but for the linear blend. What follows one
 * bone alone is moved by its matrix, many vertices at a time.
 */
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

INLINED void put_row3(float *out, size_t n, size_t i, Float3 v)
{
    out[i] = v.x;
    out[n + i] = v.y;
    out[2 * n + i] = v.z;
}

/* Along the line of equal weight, as fast as the weight changes across it. */
static inline Vector level_line(Vector gradient, Vector normal)
{
    return cross(gradient, normal);
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

/* A normal at `point`: by the cofactors of the twist's Jacobian, of determinant 1. */
INLINED Float3 twisted_normal(Twist twist, Float3 point, Float3 n)
{
    n.x -= twist.slope * (point.y * n.z - point.z * n.y);
    return twisted_about_bone(twist, n);
}

/* A direction in the skin at `point`: by the Jacobian itself. */
INLINED Float3 twisted_tangent(Twist twist, Float3 point, Float3 v)
{
    float along = twist.slope * v.x;
    v.y -= along * point.z;
    v.z += along * point.y;
    return twisted_about_bone(twist, v);
}

INLINED Float3 unit_length(Float3 n)
{
    return times(1.0f / sqrtf(n.x * n.x + n.y * n.y + n.z * n.z + FLT_MIN), n);
}

/* What a method makes of a weight: z = cosine + i sine, and the rate at which it turns by the weight. */
typedef struct Turn {
    float cosine, sine, rate;
} Turn;

/* The blended quaternion is b = 1 - w (1 - c) along 1 and w s along the axis; z = b^2 / |b|^2, and its
 * angle rises by 2 s / |b|^2. */
INLINED Turn turn_at(int method, const SkinMotion *motion, bool wound, float w)
{
    Turn turn = {1.0f + w * motion->full_cosine, w * motion->full_sine, 0.0f};
    if (method == ARM_SKIN_METHOD_LINEAR_BLEND) {
        return turn;
    }
    float versine = 1.0f - motion->cosine;
    float inverse = 1.0f / (1.0f - 2.0f * w * (1.0f - w) * versine);
    float half = w * motion->sine;
    turn.cosine = 1.0f - 2.0f * half * half * inverse;
    turn.sine = 2.0f * (1.0f - w * versine) * half * inverse;
    turn.rate = 2.0f * motion->sine * inverse;
    if (wound) {
        float s, c, cosine = turn.cosine;
        sine_and_cosine(w * motion->excess, &s, &c);
        turn.cosine = cosine * c - turn.sine * s;
        turn.sine = cosine * s + turn.sine * c;
        turn.rate += motion->excess;
    }
    return turn;
}

/* v with `along` along the turn's axis, and times a complex number across it. */
INLINED Float3 turned_by(float along, float cosine, float sine, Float3 v)
{
    Float3 f = {along, cosine * v.y - sine * v.z, sine * v.y + cosine * v.z};
    return f;
}

INLINED Float3 into_hinge(const SkinMotion *motion, Float3 v)
{
    return carried(motion->into_hinge, v);
}

/* The point within its section: made wider, and drawn in. */
INLINED Float3 in_section(int method, const SkinMotion *motion, float width, float inward, Float3 v)
{
    Float3 wider = {v.x, width * v.y, width * v.z};
    return method == ARM_SKIN_METHOD_COMPENSATED ? plus_scaled(wider, inward, motion->inward) : v;
}

/* What the centre of rotation adds: -(z - 1 - w (full - 1)) c, and its rate by the weight. */
INLINED Float3 center_shift(const SkinMotion *motion, Turn turn, float w, Float3 center)
{
    return turned_by(0.0f, 1.0f + w * motion->full_cosine - turn.cosine, w * motion->full_sine - turn.sine, center);
}

INLINED Float3 center_shift_rate(const SkinMotion *motion, Turn turn, Float3 center)
{
    return turned_by(0.0f, motion->full_cosine + turn.rate * turn.sine, motion->full_sine - turn.rate * turn.cosine,
                     center);
}

/* From the elbow to the world: what is largest last. */
INLINED Float3 shifted(const SkinMotion *motion, Float3 v)
{
    return plus_scaled(plus_scaled(v, 1.0f, motion->rest_of_shift), 1.0f, motion->shift);
}

INLINED Float3 vertex_place(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh, size_t i)
{
    float w = mesh->vertex_row[VERTEX_WEIGHT][i];
    Float3 point = row3(mesh, VERTEX_X, i);
    if (twisted) {
        point = twisted_about_bone(twist_at(motion, point.x), point);
    }
    Share at = shares_at(method, motion, wound, w).at;
    Turn turn = turn_at(method, motion, wound, w);
    Float3 place = into_hinge(motion, in_section(method, motion, at.width, at.inward, point));
    place = turned_by(place.x, turn.cosine, turn.sine, place);
    if (method == ARM_SKIN_METHOD_CENTER_OF_ROTATION) {
        Float3 center = into_hinge(motion, row3(mesh, VERTEX_CENTER_X, i));
        place = plus_scaled(place, 1.0f, center_shift(motion, turn, w, center));
    }
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        place = plus_scaled(place, at.slide, motion->hinge_slide);
    }
    return shifted(motion, carried(motion->hinge, plus_scaled(place, at.gap, motion->hinge_gap)));
}

/* J = M + u g^T: cof(J) n = cof(M) n + M (g x n) x u. Where M is a turn, that is M (n + (g x n) x M^T u),
 * and M^T dM/dw y is the axis times y at the rate of the turn. */
INLINED Float3 vertex_normal(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh, size_t i)
{
    float w = mesh->vertex_row[VERTEX_WEIGHT][i];
    Float3 point = row3(mesh, VERTEX_X, i);
    Float3 normal = row3(mesh, VERTEX_NORMAL_X, i);
    Float3 level = row3(mesh, VERTEX_LEVEL_X, i);
    if (twisted) {
        Twist twist = twist_at(motion, point.x);
        normal = twisted_normal(twist, point, normal);
        level = twisted_tangent(twist, point, level);
        point = twisted_about_bone(twist, point);
    }
    Turn turn = turn_at(method, motion, wound, w);
    if (method == ARM_SKIN_METHOD_LINEAR_BLEND) {
        float area = turn.cosine * turn.cosine + turn.sine * turn.sine;
        Float3 y = into_hinge(motion, point);
        Float3 u = plus_scaled(motion->hinge_gap, 1.0f, turned_by(0.0f, motion->full_cosine, motion->full_sine, y));
        level = into_hinge(motion, level);
        level = turned_by(level.x, turn.cosine, turn.sine, level);
        normal = into_hinge(motion, normal);
        normal = turned_by(area * normal.x, turn.cosine, turn.sine, normal);
        return unit_length(carried(motion->hinge, plus_scaled(normal, 1.0f, across(level, u))));
    }
    Shares shares = shares_at(method, motion, wound, w);
    Share at = shares.at, rate = shares.rate;
    Float3 y = into_hinge(motion, in_section(method, motion, at.width, at.inward, point));
    Float3 u = {0.0f, -turn.rate * y.z, turn.rate * y.y};
    Float3 moved = times(rate.gap, motion->hinge_gap);
    if (method == ARM_SKIN_METHOD_CENTER_OF_ROTATION) {
        Float3 center = into_hinge(motion, row3(mesh, VERTEX_CENTER_X, i));
        Float3 center_rate = into_hinge(motion, row3(mesh, VERTEX_CENTER_RATE_X, i));
        moved = plus_scaled(moved, 1.0f, center_shift_rate(motion, turn, center));
        moved = plus_scaled(moved, 1.0f, center_shift(motion, turn, w, center_rate));
    }
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        moved = plus_scaled(moved, rate.slide, motion->hinge_slide);
    }
    u = plus_scaled(u, 1.0f, turned_by(moved.x, turn.cosine, -turn.sine, moved));
    if (method == ARM_SKIN_METHOD_COMPENSATED) {
        Float3 widened = {0.0f, rate.width * point.y, rate.width * point.z};
        Float3 wide_normal = {at.width * at.width * normal.x, at.width * normal.y, at.width * normal.z};
        Float3 wide_level = {level.x, at.width * level.y, at.width * level.z};
        u = plus_scaled(u, 1.0f, into_hinge(motion, plus_scaled(widened, rate.inward, motion->inward)));
        normal = wide_normal;
        level = wide_level;
    }
    normal = plus_scaled(into_hinge(motion, normal), 1.0f, across(into_hinge(motion, level), u));
    return unit_length(carried(motion->hinge, turned_by(normal.x, turn.cosine, turn.sine, normal)));
}

/* What follows one bone alone. */
INLINED void rigid_places(const SkinMotion *motion, Matrix3 bone, Float3 rest, bool twisted, const ArmMesh *mesh,
                          size_t begin, size_t end, float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t i = begin; i < end; i++) {
        Float3 point = row3(mesh, VERTEX_X, i);
        if (twisted) {
            point = twisted_about_bone(twist_at(motion, point.x), point);
        }
        put_row3(out, n, i, plus_scaled(plus_scaled(carried(bone, point), 1.0f, rest), 1.0f, motion->shift));
    }
}

INLINED void rigid_normals(const SkinMotion *motion, Matrix3 bone, bool twisted, const ArmMesh *mesh, size_t begin,
                           size_t end, float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t i = begin; i < end; i++) {
        Float3 normal = row3(mesh, VERTEX_NORMAL_X, i);
        if (twisted) {
            Float3 point = row3(mesh, VERTEX_X, i);
            normal = unit_length(twisted_normal(twist_at(motion, point.x), point, normal));
        }
        put_row3(out, n, i, carried(bone, normal));
    }
}

/* Of the runs that bend. */
INLINED void each_vertex(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                         float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t r = 0; r < mesh->run_count; r++) {
        size_t end = mesh->run[r].holder == FOLLOWS_BOTH ? mesh->run[r].end : 0;
        for (size_t i = mesh->run[r].begin; i < end; i++) {
            put_row3(out, n, i, vertex_place(method, motion, wound, twisted, mesh, i));
        }
    }
}

INLINED void each_normal(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                         float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t r = 0; r < mesh->run_count; r++) {
        size_t end = mesh->run[r].holder == FOLLOWS_BOTH ? mesh->run[r].end : 0;
        for (size_t i = mesh->run[r].begin; i < end; i++) {
            put_row3(out, n, i, vertex_normal(method, motion, wound, twisted, mesh, i));
        }
    }
}

/* Of the others, the same by all methods. */
INLINED void each_follower(bool normals, const SkinMotion *motion, bool twisted, const ArmMesh *mesh, float *out)
{
    for (size_t r = 0; r < mesh->run_count; r++) {
        VertexRun run = mesh->run[r];
        bool forearm = run.holder == FOLLOWS_FOREARM;
        Matrix3 bone = forearm ? motion->forearm : motion->upper_arm;
        Float3 rest = plus_scaled(motion->rest_of_shift, forearm ? 1.0f : 0.0f, motion->gap);
        size_t end = run.holder == FOLLOWS_BOTH ? 0 : run.end;
        if (normals) {
            rigid_normals(motion, bone, twisted, mesh, run.begin, end, out);
        } else {
            rigid_places(motion, bone, rest, twisted, mesh, run.begin, end, out);
        }
    }
}

#endif
