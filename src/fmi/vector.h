/* Vectors and quaternions on the number type `real`.
 *
 * `real` is double in a unit, double _Complex where a unit is differentiated, and a symbolic
 * type where its equations are checked: so nothing here branches or compares.
 * Quaternions are w, x, y, z and carry body axes to world axes.
 */
#ifndef ULNA_VECTOR_H
#define ULNA_VECTOR_H

#ifndef real
#define real double
#endif

#ifndef __cplusplus
#include <tgmath.h>
#endif

typedef struct Vector {
    real x, y, z;
} Vector;

typedef struct Quaternion {
    real w, x, y, z;
} Quaternion;

static inline Vector vector(real x, real y, real z)
{
    Vector v = {x, y, z};
    return v;
}

static inline Quaternion quaternion(real w, real x, real y, real z)
{
    Quaternion q = {w, x, y, z};
    return q;
}

static inline Vector add(Vector a, Vector b)
{
    return vector(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline Vector subtract(Vector a, Vector b)
{
    return vector(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline Vector scale(real factor, Vector a)
{
    return vector(factor * a.x, factor * a.y, factor * a.z);
}

/* a + factor b: one step along b. */
static inline Vector add_scaled(Vector a, real factor, Vector b)
{
    return vector(a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z);
}

/* Element by element: a principal inertia times a body rate. */
static inline Vector multiply_elements(Vector a, Vector b)
{
    return vector(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline Vector divide_elements(Vector a, Vector b)
{
    return vector(a.x / b.x, a.y / b.y, a.z / b.z);
}

static inline real dot(Vector a, Vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline Vector cross(Vector a, Vector b)
{
    return vector(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline real norm(Vector a)
{
    return sqrt(dot(a, a));
}

static inline real quaternion_square(Quaternion q)
{
    return q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
}

/* Hamilton product: the rotation b followed by the rotation a. */
static inline Quaternion compose(Quaternion a, Quaternion b)
{
    return quaternion(a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
                      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
                      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
                      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w);
}

/* The Hamilton product q (0, v). */
static inline Quaternion compose_vector(Quaternion q, Vector v)
{
    return quaternion(-q.x * v.x - q.y * v.y - q.z * v.z, q.w * v.x + q.y * v.z - q.z * v.y,
                      q.w * v.y + q.z * v.x - q.x * v.z, q.w * v.z + q.x * v.y - q.y * v.x);
}

static inline Quaternion conjugate(Quaternion q)
{
    return quaternion(q.w, -q.x, -q.y, -q.z);
}

static inline Quaternion add_scaled_quaternion(Quaternion a, real factor, Quaternion b)
{
    return quaternion(a.w + factor * b.w, a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z);
}

static inline Quaternion normalized(Quaternion q)
{
    real inverse = 1.0 / sqrt(quaternion_square(q));
    return quaternion(inverse * q.w, inverse * q.x, inverse * q.y, inverse * q.z);
}

/* Body axes to world axes; exact for any non-zero q, whose norm divides out. */
static inline Vector rotate(Quaternion q, Vector v)
{
    Vector u = vector(q.x, q.y, q.z);
    Vector c = cross(u, v);
    Vector d = add_scaled(cross(u, c), q.w, c);
    return add_scaled(v, 2.0 / quaternion_square(q), d);
}

/* World axes to body axes. */
static inline Vector rotate_back(Quaternion q, Vector v)
{
    return rotate(conjugate(q), v);
}

/* The same rotation as a matrix, by its columns: cheaper where several vectors are turned. */
typedef struct Rotation {
    Vector x, y, z;
} Rotation;

static inline Rotation rotation(Quaternion q)
{
    real s = 2.0 / quaternion_square(q);
    real xx = s * q.x * q.x, yy = s * q.y * q.y, zz = s * q.z * q.z;
    real xy = s * q.x * q.y, yz = s * q.y * q.z, zx = s * q.z * q.x;
    real wx = s * q.w * q.x, wy = s * q.w * q.y, wz = s * q.w * q.z;
    Rotation r = {vector(1.0 - yy - zz, xy + wz, zx - wy), vector(xy - wz, 1.0 - zz - xx, yz + wx),
                  vector(zx + wy, yz - wx, 1.0 - xx - yy)};
    return r;
}

static inline Vector to_world(Rotation r, Vector v)
{
    return add_scaled(add_scaled(scale(v.x, r.x), v.y, r.y), v.z, r.z);
}

static inline Vector to_body(Rotation r, Vector v)
{
    return vector(dot(r.x, v), dot(r.y, v), dot(r.z, v));
}

/* World axes to body axes, for a q of length 1 only. */
static inline Vector unit_rotate_back(Quaternion q, Vector v)
{
    Vector u = vector(q.x, q.y, q.z);
    Vector twice = scale(2.0, cross(v, u));
    return add(add_scaled(v, q.w, twice), cross(twice, u));
}

/* dq/dt = (0, w) q / 2 for an angular velocity w in world axes. */
static inline Quaternion quaternion_rate(Quaternion q, Vector angular_velocity)
{
    Vector w = angular_velocity;
    Quaternion p = compose(quaternion(0.0, w.x, w.y, w.z), q);
    return quaternion(0.5 * p.w, 0.5 * p.x, 0.5 * p.y, 0.5 * p.z);
}

/* The rotation by an angle about a unit axis. */
static inline Quaternion rotation_about(Vector axis, real angle)
{
    real half = 0.5 * angle;
    Vector u = scale(sin(half), axis);
    return quaternion(cos(half), u.x, u.y, u.z);
}

#endif
