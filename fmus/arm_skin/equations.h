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

/* The forearm's motion away from rest, seen from the upper arm: y -> R(rotation) y + gap. What it
 * is turned beyond half a turn is kept apart: rotation = near, then `excess` about `axis`. */
typedef struct Bend {
    Quaternion rotation;
    Vector gap; /* between the two bones' elbows; zero where the joint holds */
    Quaternion near;
    Vector axis;
    real excess; /* rad */
} Bend;

static inline Vector arm_skin_elbow(const ArmSkin *skin)
{
    return vector(skin->upper_arm_length, 0.0, 0.0);
}

/* At most half a turn. */
static inline Bend bend_by(Quaternion rotation, Vector gap)
{
    Bend bend = {rotation, gap, rotation, vector(1.0, 0.0, 0.0), 0.0};
    return bend;
}

static inline Bend arm_skin_bend(const ArmSkin *skin)
{
    Quaternion upper_arm = normalized(skin->upper_arm_orientation);
    Quaternion forearm = normalized(skin->forearm_orientation);
    Vector reach = rotate_back(upper_arm, subtract(skin->forearm_position, skin->upper_arm_position));
    return bend_by(compose(conjugate(upper_arm), forearm), subtract(reach, arm_skin_elbow(skin)));
}

/* Linear blend: the mean of the two images. */
static inline Vector linear_blend_point(Bend bend, real weight, Vector point)
{
    Vector carried = add(rotate(bend.rotation, point), bend.gap);
    return add_scaled(point, weight, subtract(carried, point));
}

/* (1 - w) 1 + w q: not of unit norm, but `rotate` divides that out. */
static inline Quaternion near_rotation(Bend bend, real weight)
{
    Quaternion identity = quaternion(1.0 - weight, 0.0, 0.0, 0.0);
    return add_scaled_quaternion(identity, weight, bend.near);
}

/* All of the turn at a weight: what is beyond half a turn is spread evenly. */
static inline Quaternion blended_rotation(Bend bend, real weight)
{
    return compose(near_rotation(bend, weight), rotation_about(bend.axis, weight * bend.excess));
}

/* Both bones turn about the elbow, so the skin does; what their elbows are apart is shared. */
static inline Vector hinge_point(Bend bend, real weight, Vector point)
{
    return add_scaled(rotate(blended_rotation(bend, weight), point), weight, bend.gap);
}

/* Dual quaternions (Kavan et al. 2008): b + eps d = (1 - w) 1 + w (q + eps gap q / 2), divided by
 * its norm; it moves y to R(b) y + 2 vec(d b*) / |b|^2. */
static inline Vector dual_quaternion_point(Bend bend, real weight, Vector point)
{
    Vector g = bend.gap;
    Quaternion b = near_rotation(bend, weight);
    Quaternion twice_dual = compose(quaternion(0.0, g.x, g.y, g.z), bend.near);
    Quaternion shift = compose(twice_dual, conjugate(b));
    return add_scaled(rotate(blended_rotation(bend, weight), point), weight / quaternion_square(b),
                      vector(shift.x, shift.y, shift.z));
}

/* Optimised centres of rotation (Le and Hodgins 2016): the blended rotation about a centre that
 * follows the linear blend. */
static inline Vector center_of_rotation_point(Bend bend, real weight, Vector center, Vector point)
{
    Vector carried = rotate(blended_rotation(bend, weight), subtract(point, center));
    return add(linear_blend_point(bend, weight, center), carried);
}

/* Where the bulge of `hinge` is, and how far a section is drawn in against it, in half widths of the
 * zone and in sines of half the turn. The constant balances what is left of the bulge with what the
 * widening makes of it. */
#define SECTION_DRAW 0.32

static inline real draw_at(real weight)
{
    real lean = 1.0 - 2.0 * weight;
    return SECTION_DRAW * weight * (1.0 - weight) * (1.0 + 3.0 * lean * lean);
}

/* How the widening is shared out. */
static inline real widening_at(real weight)
{
    return 4.0 * weight * (1.0 - weight);
}

/* The hinge's rotation, after each section is moved in its own plane toward the inner elbow and made
 * wider: `half_width` of the blend zone, `widening` at its middle. */
static inline Vector compensated_point(Bend bend, real weight, real half_width, real widening, Vector point)
{
    Vector t = vector(bend.near.x, bend.near.y, bend.near.z);
    Vector inward = cross(t, vector(1.0, 0.0, 0.0));
    real width = 1.0 + widening * widening_at(weight);
    Vector wider = vector(point.x, width * point.y, width * point.z);
    return hinge_point(bend, weight, add_scaled(wider, half_width * draw_at(weight), inward));
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

/* What follows compares numbers, so it is for C alone. */
#ifdef __cplusplus
static inline void arm_skin_initialize(ArmSkin *skin)
{
    (void)skin;
}
#else
#include "measures.h"
#endif

#endif
