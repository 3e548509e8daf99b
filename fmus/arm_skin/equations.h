/* ArmSkin: a point of the skin carried by two bones, and the capsules that stand for the arm.
 *
 * At rest the arm lies along +x, the shoulder at the origin, the elbow at upper_arm_length. A pose
 * maps a bone's rest frame (its own proximal end) to the world:
 *
 *   upper arm  x -> p_u + R_u x                forearm  x -> p_f + R_f (x - elbow)
 *
 * Blending commutes with a rigid motion of the whole arm, so points are blended in the axes of the
 * upper arm, from the elbow, where only the forearm moves.
 */
#ifndef ARM_SKIN_EQUATIONS_H
#define ARM_SKIN_EQUATIONS_H

#include "vector.h"
#include "variables.h"

/* The forearm's motion away from rest, seen from the upper arm: y -> R(rotation) y + gap. */
typedef struct Bend {
    Quaternion rotation;
    Vector gap; /* between the two bones' elbows; zero where the joint holds */
} Bend;

static inline Vector arm_skin_elbow(const ArmSkin *skin)
{
    return vector(skin->upper_arm_length, 0.0, 0.0);
}

static inline Bend arm_skin_bend(const ArmSkin *skin)
{
    Quaternion upper_arm = normalized(skin->upper_arm_orientation);
    Quaternion forearm = normalized(skin->forearm_orientation);
    Vector reach = rotate_back(upper_arm, subtract(skin->forearm_position, skin->upper_arm_position));
    Bend bend = {compose(conjugate(upper_arm), forearm), subtract(reach, arm_skin_elbow(skin))};
    return bend;
}

/* Linear blend: the mean of the two images. */
static inline Vector linear_blend_point(Bend bend, real weight, Vector point)
{
    Vector carried = add(rotate(bend.rotation, point), bend.gap);
    return add_scaled(point, weight, subtract(carried, point));
}

/* (1 - w) 1 + w q: not of unit norm, but `rotate` divides that out. */
static inline Quaternion blended_rotation(Bend bend, real weight)
{
    Quaternion identity = quaternion(1.0 - weight, 0.0, 0.0, 0.0);
    return add_scaled_quaternion(identity, weight, bend.rotation);
}

/* Dual quaternions (Kavan et al. 2008): b + eps d = (1 - w) 1 + w (q + eps gap q / 2), divided by
 * its norm; it moves y to R(b) y + 2 vec(d b*) / |b|^2. */
static inline Vector dual_quaternion_point(Bend bend, real weight, Vector point)
{
    Vector g = bend.gap;
    Quaternion b = blended_rotation(bend, weight);
    Quaternion twice_dual = compose(quaternion(0.0, g.x, g.y, g.z), bend.rotation);
    Quaternion shift = compose(twice_dual, conjugate(b));
    return add_scaled(rotate(b, point), weight / quaternion_square(b), vector(shift.x, shift.y, shift.z));
}

/* No states: all follows from the inputs. */
static inline void arm_skin_initialize(ArmSkin *skin)
{
    (void)skin;
}

/* The capsules cover the arm's rest shape exactly: its round ends lie within the bones' lengths. */
static inline void arm_skin_outputs(ArmSkin *skin, const void *workspace)
{
    (void)workspace;
    Vector shoulder = vector(skin->radius, 0.0, 0.0);
    Vector hand = vector(skin->forearm_length - skin->radius, 0.0, 0.0);
    skin->capsule_1_start = add(skin->upper_arm_position, rotate(skin->upper_arm_orientation, shoulder));
    skin->capsule_1_end = add(skin->upper_arm_position, rotate(skin->upper_arm_orientation, arm_skin_elbow(skin)));
    skin->capsule_1_radius = skin->radius;
    skin->capsule_2_start = skin->forearm_position;
    skin->capsule_2_end = add(skin->forearm_position, rotate(skin->forearm_orientation, hand));
    skin->capsule_2_radius = skin->radius;
}

/* The measures compare numbers, so they are for C alone. */
#ifndef __cplusplus
#include "measures.h"
#endif

#endif
