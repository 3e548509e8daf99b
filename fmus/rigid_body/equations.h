/* RigidBody: the Newton-Euler equations in the momenta.
 *
 *   dx/dt = P / m                      dP/dt = F + m g
 *   dq/dt = (0, w) q / 2               dL/dt = tau
 *   w = R I^-1 R^T L                   R = R(q), body to world
 *
 * With R from body to world the inertia in the world is R I R^T. The class notes' R^T I R holds for
 * the opposite convention only.
 */
#ifndef RIGID_BODY_EQUATIONS_H
#define RIGID_BODY_EQUATIONS_H

#include "vector.h"
#include "variables.h"

/* Forces by the place where they act, and all free torque, in the world. */
typedef struct Loads {
    Vector force; /* at the centre of mass, weight included */
    Vector base_force, tip_force;
    Vector torque;
} Loads;

static inline Loads rigid_body_loads(const RigidBody *body)
{
    Loads loads;
    loads.force = add_scaled(body->force, body->mass, body->gravity);
    loads.base_force = body->base_force;
    loads.tip_force = body->tip_force;
    loads.torque = add(body->torque, add(body->base_torque, body->tip_torque));
    return loads;
}

/* All force, and all torque about the centre of mass, in the world. */
typedef struct Wrench {
    Vector force, torque;
} Wrench;

static inline Wrench rigid_body_wrench(const RigidBody *body, Loads loads, Rotation attitude)
{
    Vector base = to_world(attitude, body->base);
    Vector tip = to_world(attitude, body->tip);
    Wrench total;
    total.force = add(loads.force, add(loads.base_force, loads.tip_force));
    total.torque = add(loads.torque, add(cross(base, loads.base_force), cross(tip, loads.tip_force)));
    return total;
}

/* w = R I^-1 R^T L */
static inline Vector rigid_body_angular_velocity(const RigidBody *body, Rotation attitude, Vector angular_momentum)
{
    return to_world(attitude, divide_elements(to_body(attitude, angular_momentum), body->inertia));
}

static inline void rigid_body_initialize(RigidBody *body)
{
    Quaternion q = normalized(body->initial_orientation);
    Vector body_rate = rotate_back(q, body->initial_angular_velocity);
    body->position = body->initial_position;
    body->orientation = q;
    body->linear_momentum = scale(body->mass, body->initial_velocity);
    body->angular_momentum = rotate(q, multiply_elements(body->inertia, body_rate));
}

static inline void rigid_body_derivatives(RigidBody *body)
{
    Rotation attitude = rotation(body->orientation);
    Wrench total = rigid_body_wrench(body, rigid_body_loads(body), attitude);
    Vector w = rigid_body_angular_velocity(body, attitude, body->angular_momentum);
    body->der_position = scale(1.0 / body->mass, body->linear_momentum);
    body->der_orientation = quaternion_rate(body->orientation, w);
    body->der_linear_momentum = total.force;
    body->der_angular_momentum = total.torque;
}

static inline void rigid_body_outputs(RigidBody *body)
{
    Rotation attitude = rotation(body->orientation);
    Vector L = body->angular_momentum;
    Wrench total = rigid_body_wrench(body, rigid_body_loads(body), attitude);
    Vector v = scale(1.0 / body->mass, body->linear_momentum);
    Vector a = scale(1.0 / body->mass, total.force);
    Vector w = rigid_body_angular_velocity(body, attitude, L);
    /* I dw/dt = tau - w x L, both sides in the world */
    Vector dw = rigid_body_angular_velocity(body, attitude, subtract(total.torque, cross(w, L)));
    Vector base = to_world(attitude, body->base);
    Vector tip = to_world(attitude, body->tip);

    body->velocity = v;
    body->angular_velocity = w;
    body->acceleration = a;
    body->angular_acceleration = dw;
    body->base_position = add(body->position, base);
    body->base_velocity = add(v, cross(w, base));
    body->base_acceleration = add(a, add(cross(dw, base), cross(w, cross(w, base))));
    body->tip_position = add(body->position, tip);
    body->tip_velocity = add(v, cross(w, tip));
    body->tip_acceleration = add(a, add(cross(dw, tip), cross(w, cross(w, tip))));
    body->kinetic_energy = 0.5 * (dot(body->linear_momentum, v) + dot(L, w));
    body->potential_energy = -body->mass * dot(body->gravity, body->position);
}

#endif
