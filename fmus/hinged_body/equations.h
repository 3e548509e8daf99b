/* HingedBody: the Newton-Euler equations of a body with one freedom, the angle about `axis`.
 *
 *   w     = w_a + rate n                          n: the axis in the world
 *   dw/dt = dw_a/dt + rate w_a x n + d(rate)/dt n
 *   a     = a_a + dw/dt x c + w x (w x c)         c: from the hinge to the centre of mass
 *   force  = m (a - g) - F_tip                    of the anchor on the body, at the hinge
 *   torque = I dw/dt + w x I w + c x m (a - g) - tau_tip - tip x F_tip
 *   n . torque = stiffness (target - angle) - (damping + friction) rate + input torque
 *
 * The last line is the equation of motion: the component about the axis is all that the hinge
 * leaves free. All is computed in body axes, where axis, inertia and levers do not change.
 */
#ifndef HINGED_BODY_EQUATIONS_H
#define HINGED_BODY_EQUATIONS_H

#include "vector.h"
#include "variables.h"

/* Everything in body axes. */
typedef struct HingedMotion {
    Quaternion orientation;
    Vector angular_velocity;
    Vector angular_acceleration;
    real rate_rate;           /* second derivative of the angle */
    Vector force, torque;     /* of the anchor on the body, at the hinge */
} HingedMotion;

static inline Quaternion hinged_body_orientation(const HingedBody *body)
{
    return compose(normalized(body->anchor_orientation), rotation_about(body->axis, body->angle));
}

static inline HingedMotion hinged_body_motion(const HingedBody *body)
{
    Vector n = body->axis;
    Vector c = body->center_of_mass;
    Quaternion q = hinged_body_orientation(body);
    Vector anchor_rate = rotate_back(q, body->anchor_angular_velocity);
    Vector tip_force = rotate_back(q, body->tip_force);
    Vector tip_torque = add(rotate_back(q, body->tip_torque), cross(body->tip, tip_force));
    /* weight as if the hinge accelerated upwards */
    Vector hinge_acceleration = rotate_back(q, subtract(body->anchor_acceleration, body->gravity));

    /* what it would take if the rate did not change */
    Vector w = add_scaled(anchor_rate, body->rate, n);
    Vector dw = add_scaled(rotate_back(q, body->anchor_angular_acceleration), body->rate, cross(anchor_rate, n));
    Vector turning = add(cross(dw, c), cross(w, cross(w, c)));
    Vector force = scale(body->mass, add(hinge_acceleration, turning));
    Vector gyroscopic = cross(w, multiply_elements(body->inertia, w));
    Vector torque = subtract(add(add(multiply_elements(body->inertia, dw), gyroscopic), cross(c, force)), tip_torque);

    /* what each unit of change of the rate takes besides */
    Vector force_per = scale(body->mass, cross(n, c));
    Vector torque_per = add(multiply_elements(body->inertia, n), cross(c, force_per));

    real muscle = body->stiffness * (body->target_angle - body->angle) - body->damping * body->rate;
    real driving = muscle - body->friction * body->rate + body->torque;

    HingedMotion motion;
    motion.orientation = q;
    motion.rate_rate = (driving - dot(n, torque)) / dot(n, torque_per);
    motion.angular_velocity = w;
    motion.angular_acceleration = add_scaled(dw, motion.rate_rate, n);
    motion.force = subtract(add_scaled(force, motion.rate_rate, force_per), tip_force);
    motion.torque = add_scaled(torque, motion.rate_rate, torque_per);
    return motion;
}

static inline void hinged_body_initialize(HingedBody *body)
{
    body->angle = body->initial_angle;
    body->rate = body->initial_rate;
}

static inline void hinged_body_derivatives(HingedBody *body)
{
    body->der_angle = body->rate;
    body->der_rate = hinged_body_motion(body).rate_rate;
}

static inline void hinged_body_outputs(HingedBody *body)
{
    HingedMotion motion = hinged_body_motion(body);
    Quaternion q = motion.orientation;
    Vector axis = rotate(body->anchor_orientation, body->axis);
    Vector w = add_scaled(body->anchor_angular_velocity, body->rate, axis);
    Vector dw = rotate(q, motion.angular_acceleration);
    Vector center = rotate(q, body->center_of_mass);
    Vector tip = rotate(q, body->tip);
    Vector center_velocity = add(body->anchor_velocity, cross(w, center));
    Vector momentum = multiply_elements(body->inertia, motion.angular_velocity);
    real stretch = body->target_angle - body->angle;

    body->position = body->anchor_position;
    body->orientation = q;
    body->tip_position = add(body->anchor_position, tip);
    body->tip_orientation = q;
    body->tip_velocity = add(body->anchor_velocity, cross(w, tip));
    body->tip_angular_velocity = w;
    body->tip_acceleration = add(body->anchor_acceleration, add(cross(dw, tip), cross(w, cross(w, tip))));
    body->tip_angular_acceleration = dw;
    body->reaction_force = scale(-1.0, rotate(q, motion.force));
    body->reaction_torque = scale(-1.0, rotate(q, motion.torque));
    body->kinetic_energy = 0.5 * (body->mass * dot(center_velocity, center_velocity)
                                  + dot(momentum, motion.angular_velocity));
    body->potential_energy = 0.5 * body->stiffness * stretch * stretch
                             - body->mass * dot(body->gravity, add(body->anchor_position, center));
}

#endif
