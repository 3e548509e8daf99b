/* CompliantJoint: springs and dampers between two frames, one axis free to turn.
 *
 *   r = p2 - p1      w = w2 - w1      n1 = R1 axis, n2 = R2 axis
 *   u = v2 - v1 - (w1 + w2)/2 x r                          of the two bodies, where they meet half way
 *   U = stiffness r^2 / 2 + angular_stiffness (1 - n1.n2)
 *   D = damping u^2 + sum over n = n1, n2 of (angular_damping |n x w|^2 + friction (n.w)^2) / 2
 *
 *   force on second = -stiffness r - damping u             acts half way, as does its opposite on first:
 *   torque          = -r x force / 2                       on either, about its own frame
 *                     -+ dU/d(turn) -+ dD/dw / 2           on second and first
 *
 * D is the dissipated power. No frame comes first; total force and total moment vanish.
 */
#ifndef COMPLIANT_JOINT_EQUATIONS_H
#define COMPLIANT_JOINT_EQUATIONS_H

#include "vector.h"
#include "variables.h"

/* No states: all follows from the inputs. */
static inline void compliant_joint_initialize(CompliantJoint *joint)
{
    (void)joint;
}

static inline void compliant_joint_outputs(CompliantJoint *joint)
{
    Vector gap = subtract(joint->second_position, joint->first_position);
    Vector mean_turning = scale(0.5, add(joint->first_angular_velocity, joint->second_angular_velocity));
    Vector sliding = subtract(subtract(joint->second_velocity, joint->first_velocity), cross(mean_turning, gap));
    Vector braking = scale(-joint->damping, sliding);
    Vector force = add_scaled(braking, -joint->stiffness, gap);
    /* the spring pulls along the gap, so only braking has a moment */
    Vector lever_torque = scale(-0.5, cross(gap, braking));

    Vector first_axis = rotate(joint->first_orientation, joint->axis);
    Vector second_axis = rotate(joint->second_orientation, joint->axis);
    Vector tilt = cross(first_axis, second_axis);
    Vector turning = subtract(joint->second_angular_velocity, joint->first_angular_velocity);
    Vector across_first = cross(first_axis, turning), across_second = cross(second_axis, turning);
    real along_first = dot(first_axis, turning), along_second = dot(second_axis, turning);
    /* n x (n x w) is minus the part of w across n */
    Vector across = add(cross(first_axis, across_first), cross(second_axis, across_second));
    Vector along = add_scaled(scale(along_first, first_axis), along_second, second_axis);
    Vector brake = add_scaled(scale(0.5 * joint->angular_damping, across), -0.5 * joint->friction, along);
    Vector turning_torque = add_scaled(brake, -joint->angular_stiffness, tilt);

    /* sums of squares: small angles keep their digits, and no rounding makes them negative */
    Vector chord = subtract(second_axis, first_axis);
    real across_square = dot(across_first, across_first) + dot(across_second, across_second);
    real along_square = along_first * along_first + along_second * along_second;

    joint->first_force = scale(-1.0, force);
    joint->first_torque = subtract(lever_torque, turning_torque);
    joint->second_force = force;
    joint->second_torque = add(lever_torque, turning_torque);
    joint->displacement = rotate_back(joint->first_orientation, gap);
    joint->misalignment = rotate_back(joint->first_orientation, tilt);
    joint->potential_energy = 0.5 * (joint->stiffness * dot(gap, gap) + joint->angular_stiffness * dot(chord, chord));
    joint->dissipation = joint->damping * dot(sliding, sliding)
                         + 0.5 * (joint->angular_damping * across_square + joint->friction * along_square);
}

#endif
