/* ArmSkin: rings of vertices. A ring has one weight, so its map is made once for all its vertices:
 * what is left for each is center + y first + z second, y and z the cosine and sine of its spoke.
 */
#ifndef ARM_SKIN_RINGS_H
#define ARM_SKIN_RINGS_H

#include "motion.h"
#include "mesh.h"

#include <float.h>

enum { RINGS_AT_ONCE = 16 };

/* A number for each of some rings. */
typedef struct RingFloat3 {
    float x[RINGS_AT_ONCE], y[RINGS_AT_ONCE], z[RINGS_AT_ONCE];
} RingFloat3;

INLINED void put(RingFloat3 *rows, size_t i, Float3 v)
{
    rows->x[i] = v.x;
    rows->y[i] = v.y;
    rows->z[i] = v.z;
}

INLINED Float3 pick(const RingFloat3 *rows, size_t i)
{
    Float3 v = {rows->x[i], rows->y[i], rows->z[i]};
    return v;
}

/* The vector from a ring's middle to spoke y turned by the twist, and that to spoke z. */
INLINED void twist_pair(bool twisted, float angle, Float3 *first, Float3 *second)
{
    if (twisted) {
        float sine, cosine;
        sine_and_cosine(angle, &sine, &cosine);
        Float3 a = plus_scaled(times(cosine, *first), sine, *second);
        *second = plus_scaled(times(cosine, *second), -sine, *first);
        *first = a;
    }
}

typedef struct RingPlaces {
    RingFloat3 center, rest, first, second; /* center + rest: in float32, one number is too coarse */
} RingPlaces;

INLINED void place_ring(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                              size_t ring, size_t i, RingPlaces *places)
{
    float x = mesh->ring_row[RING_X][ring];
    float w = mesh->ring_row[RING_WEIGHT][ring];
    Shares shares = shares_at(method, motion, wound, w);
    Matrix3 m = share_matrix(motion, &shares.at, w);
    Float3 center = times(x, m.x);
    if (method == ARM_SKIN_METHOD_CENTER_OF_ROTATION) {
        float c = -mesh->ring_row[RING_CENTER][ring];
        center = plus_scaled(plus_scaled(center, c * shares.at.first, motion->first.x), c * shares.at.second, motion->second.x);
    }
    if (method == ARM_SKIN_METHOD_COMPENSATED) {
        center = plus_scaled(center, shares.at.inward, carried(m, motion->inward));
    }
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        center = plus_scaled(center, shares.at.slide, motion->slide);
    }
    center = plus_scaled(center, shares.at.gap, motion->gap);
    Float3 shift = motion->shift;
    Float3 rest = {sum_error(shift.x, center.x), sum_error(shift.y, center.y), sum_error(shift.z, center.z)};
    float radius = mesh->ring_row[RING_RADIUS][ring] * shares.at.width;
    Float3 first = times(radius, m.y);
    Float3 second = times(radius, m.z);
    twist_pair(twisted, motion->spread * mesh->ring_row[RING_SPREAD][ring], &first, &second);
    put(&places->center, i, plus_scaled(center, 1.0f, shift));
    put(&places->rest, i, plus_scaled(rest, 1.0f, motion->rest_of_shift));
    put(&places->first, i, first);
    put(&places->second, i, second);
}

INLINED void spread_ring(const ArmMesh *mesh, float center, float rest, float first, float second,
                         float *restrict out)
{
    for (size_t k = 0; k < RING_VERTICES; k++) {
        out[k] = center + ((rest + mesh->spoke_y[k] * first) + mesh->spoke_z[k] * second);
    }
}

/* cof(J) n of spoke (y, z): constant + y (first + y yy + z yz) + z (second + z zz). */
typedef struct RingNormals {
    RingFloat3 constant, first, second, yy, yz, zz;
} RingNormals;

/* J = M + u g^T, g = slope e_x: cof(J) n = cof(M) n + M (g x n) x u; M with the sections' width. */
INLINED void ring_normal(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                               size_t ring, size_t i, RingNormals *normals)
{
    float x = mesh->ring_row[RING_X][ring];
    float w = mesh->ring_row[RING_WEIGHT][ring];
    float radius = mesh->ring_row[RING_RADIUS][ring];
    float radial = mesh->ring_row[RING_NORMAL_RADIAL][ring];
    float slope = mesh->ring_row[RING_SLOPE][ring] * radial;
    Shares shares = shares_at(method, motion, wound, w);
    Share at = shares.at, rate = shares.rate;
    Matrix3 m = share_matrix(motion, &at, w);
    Matrix3 m_rate = share_matrix_rate(motion, &rate);

    Float3 u = times(x, m_rate.x);
    Float3 uy = times(radius * at.width, m_rate.y);
    Float3 uz = times(radius * at.width, m_rate.z);
    if (method == ARM_SKIN_METHOD_CENTER_OF_ROTATION) {
        float c = -mesh->ring_row[RING_CENTER][ring];
        float c_rate = -mesh->ring_row[RING_CENTER_RATE][ring];
        u = plus_scaled(u, c * rate.first + c_rate * at.first, motion->first.x);
        u = plus_scaled(u, c * rate.second + c_rate * at.second, motion->second.x);
    }
    if (method == ARM_SKIN_METHOD_COMPENSATED) {
        u = plus_scaled(u, at.inward, carried(m_rate, motion->inward));
        u = plus_scaled(u, rate.inward, carried(m, motion->inward));
        uy = plus_scaled(uy, radius * rate.width, m.y);
        uz = plus_scaled(uz, radius * rate.width, m.z);
    }
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        u = plus_scaled(u, rate.slide, motion->slide);
    }
    u = plus_scaled(u, rate.gap, motion->gap);

    Float3 my = times(at.width, m.y);
    Float3 mz = times(at.width, m.z);
    Float3 along = times(mesh->ring_row[RING_NORMAL_X][ring], across(my, mz));
    Float3 first = times(radial, across(mz, m.x));
    Float3 second = times(radial, across(m.x, my));
    twist_pair(twisted, motion->spread * mesh->ring_row[RING_SPREAD][ring], &first, &second);
    put(&normals->constant, i, along);
    put(&normals->first, i, plus_scaled(first, slope, across(mz, u)));
    put(&normals->second, i, plus_scaled(second, -slope, across(my, u)));
    put(&normals->yy, i, times(slope, across(mz, uy)));
    put(&normals->yz, i, times(slope, plus_scaled(across(mz, uz), -1.0f, across(my, uy))));
    put(&normals->zz, i, times(-slope, across(my, uz)));
}

INLINED void spread_normals(const ArmMesh *mesh, const RingNormals *normals, size_t i, size_t n, float *restrict out)
{
    Float3 constant = pick(&normals->constant, i);
    Float3 first = pick(&normals->first, i), second = pick(&normals->second, i);
    Float3 yy = pick(&normals->yy, i), yz = pick(&normals->yz, i), zz = pick(&normals->zz, i);
    for (size_t k = 0; k < RING_VERTICES; k++) {
        float y = mesh->spoke_y[k];
        float z = mesh->spoke_z[k];
        Float3 by_y = plus_scaled(plus_scaled(first, y, yy), z, yz);
        Float3 by_z = plus_scaled(second, z, zz);
        Float3 normal = plus_scaled(plus_scaled(constant, y, by_y), z, by_z);
        /* the smallest normal number stands in for the length of a normal that has none */
        float inverse = 1.0f / sqrtf(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z + FLT_MIN);
        out[k] = inverse * normal.x;
        out[n + k] = inverse * normal.y;
        out[2 * n + k] = inverse * normal.z;
    }
}

INLINED size_t at_once(const ArmMesh *mesh, size_t begin)
{
    size_t left = mesh->ring_count - begin;
    return left < RINGS_AT_ONCE ? left : RINGS_AT_ONCE;
}

INLINED void ring_vertices(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                                 float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t begin = 0; begin < mesh->ring_count; begin += RINGS_AT_ONCE) {
        RingPlaces places;
        size_t count = at_once(mesh, begin);
        for (size_t i = 0; i < count; i++) {
            place_ring(method, motion, wound, twisted, mesh, begin + i, i, &places);
        }
        for (size_t i = 0; i < count; i++) {
            float *ring = out + (begin + i) * RING_VERTICES;
            spread_ring(mesh, places.center.x[i], places.rest.x[i], places.first.x[i], places.second.x[i], ring);
            spread_ring(mesh, places.center.y[i], places.rest.y[i], places.first.y[i], places.second.y[i], ring + n);
            spread_ring(mesh, places.center.z[i], places.rest.z[i], places.first.z[i], places.second.z[i], ring + 2 * n);
        }
    }
}

INLINED void ring_normals(int method, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                                float *restrict out)
{
    size_t n = mesh->vertex_count;
    for (size_t begin = 0; begin < mesh->ring_count; begin += RINGS_AT_ONCE) {
        RingNormals normals;
        size_t count = at_once(mesh, begin);
        for (size_t i = 0; i < count; i++) {
            ring_normal(method, motion, wound, twisted, mesh, begin + i, i, &normals);
        }
        for (size_t i = 0; i < count; i++) {
            spread_normals(mesh, &normals, i, n, out + (begin + i) * RING_VERTICES);
        }
    }
}

#endif
