/* RigidBody: half a kick by the torque, free rotation, half a kick; free rotation by splitting.
 *
 * Without torque L is not touched. Nothing here branches.
 */
#include "equations.h"

/* Turns the body by a free rotation of duration h. */
typedef Motion (*FreeRotation)(const RigidBody *body, Motion motion, real h);

/* Strang splitting: order 2 under torque whatever the free rotation's own. The forces do not depend
 * on the attitude and are linear in time, so translation is exact. */
static inline Motion strang_step(const RigidBody *body, const LinearLoads *loads, Motion m, real elapsed, real h,
                                 FreeRotation free_rotation)
{
    Wrench before = rigid_body_wrench(body, loads_at(loads, elapsed), rotation(m.orientation));
    m.angular_momentum = add_scaled(m.angular_momentum, h / 2.0, before.torque);
    m = free_rotation(body, m, h);
    Wrench after = rigid_body_wrench(body, loads_at(loads, elapsed + h), rotation(m.orientation));
    m.angular_momentum = add_scaled(m.angular_momentum, h / 2.0, after.torque);

    Vector mean = add_scaled(m.linear_momentum, h / 6.0, add_scaled(after.force, 2.0, before.force));
    m.position = add_scaled(m.position, h / body->mass, mean);
    m.linear_momentum = add_scaled(m.linear_momentum, h / 2.0, add(before.force, after.force));
    return m;
}

/* A part of a free rotation: the attitude, and the momentum in body axes, which turns the other way. */
typedef struct Turning {
    Quaternion orientation;
    Vector momentum;
} Turning;

/* Exact flows of the energies m_x^2 / (2 I_x), m_y^2 / (2 I_y), m_z^2 / (2 I_z): turns about one axis. */
static inline Turning turned_about_x(Turning t, real rate_per_momentum)
{
    real half = 0.5 * rate_per_momentum * t.momentum.x;
    real c = cos(half), s = sin(half), cc = c * c - s * s, ss = 2.0 * c * s;
    Quaternion q = t.orientation;
    Vector m = t.momentum;
    t.orientation = quaternion(c * q.w - s * q.x, c * q.x + s * q.w, c * q.y + s * q.z, c * q.z - s * q.y);
    t.momentum = vector(m.x, cc * m.y + ss * m.z, cc * m.z - ss * m.y);
    return t;
}

static inline Turning turned_about_y(Turning t, real rate_per_momentum)
{
    real half = 0.5 * rate_per_momentum * t.momentum.y;
    real c = cos(half), s = sin(half), cc = c * c - s * s, ss = 2.0 * c * s;
    Quaternion q = t.orientation;
    Vector m = t.momentum;
    t.orientation = quaternion(c * q.w - s * q.y, c * q.x - s * q.z, c * q.y + s * q.w, c * q.z + s * q.x);
    t.momentum = vector(cc * m.x - ss * m.z, m.y, cc * m.z + ss * m.x);
    return t;
}

static inline Turning turned_about_z(Turning t, real rate_per_momentum)
{
    real half = 0.5 * rate_per_momentum * t.momentum.z;
    real c = cos(half), s = sin(half), cc = c * c - s * s, ss = 2.0 * c * s;
    Quaternion q = t.orientation;
    Vector m = t.momentum;
    t.orientation = quaternion(c * q.w - s * q.z, c * q.x + s * q.y, c * q.y - s * q.x, c * q.z + s * q.w);
    t.momentum = vector(cc * m.x + ss * m.y, cc * m.y - ss * m.x, m.z);
    return t;
}

/* Dullweber, Leimkuhler and McLachlan, J. Chem. Phys. 107 (1997) 5840: the energy's three parts, there
 * and back. Each flow is symplectic, and so is the step. */
static inline Motion five_rotations(const RigidBody *body, Motion m, real h)
{
    Turning t = {m.orientation, to_body(rotation(m.orientation), m.angular_momentum)};
    t = turned_about_x(t, h / 2.0 / body->inertia.x);
    t = turned_about_y(t, h / 2.0 / body->inertia.y);
    t = turned_about_z(t, h / body->inertia.z);
    t = turned_about_y(t, h / 2.0 / body->inertia.y);
    t = turned_about_x(t, h / 2.0 / body->inertia.x);
    m.orientation = normalized(t.orientation);
    return m;
}

static Motion splitting_step(const RigidBody *body, const LinearLoads *loads, Motion m, real elapsed, real h)
{
    return strang_step(body, loads, m, elapsed, h, five_rotations);
}
