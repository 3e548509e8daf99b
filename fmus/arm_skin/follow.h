/* ArmSkin: the relative rotation, followed through any number of turns.
 *
 * A rotation has many rotation vectors, 360 degrees apart along one axis; 190 degrees and -170 are
 * one pose and two skins. Of them the one nearest to that of the last step is taken, and of the
 * angles of the forearm's twist likewise. On `real`; comparisons are of `value_of`.
 */
#ifndef ARM_SKIN_FOLLOW_H
#define ARM_SKIN_FOLLOW_H

#include <complex.h>

/* The number without its infinitesimal part. */
#define value_of(x) creal(x)

static const double half_turn = 3.14159265358979323846;

/* Below these the axis of a turn, or the twist of a forearm that points straight back, is noise. */
#define LEAST_SINE 1e-12
#define LEAST_COSINE 1e-6

/* The motion of the forearm: first its twist, shared out along it, then the bend at the elbow. */
typedef struct ArmMotion {
    Bend bend;
    real twist;      /* rad, all of it */
    real spread;     /* rad, the part that is shared out along the forearm */
    Vector turn;     /* the bend's rotation vector, without infinitesimal parts, rad */
} ArmMotion;

static inline double nearest_turn(double angle, double last)
{
    return angle + 2.0 * half_turn * round((last - angle) / (2.0 * half_turn));
}

/* 2 atan2(sine, cosine) near `last`, with its infinitesimal part. */
static inline real followed_angle(real sine, real cosine, double last)
{
    double s = value_of(sine), c = value_of(cosine);
    double angle = nearest_turn(2.0 * atan2(s, c), last);
    return angle + 2.0 * (c * (sine - s) - s * (cosine - c)) / (s * s + c * c);
}

/* The angle about the forearm's own axis: all of its rotation that moves no point of the bone. */
static inline real followed_twist(Quaternion q, double last)
{
    bool straight_back = hypot(value_of(q.x), value_of(q.w)) < LEAST_COSINE;
    return straight_back ? last : followed_angle(q.x, q.w, last);
}

/* Sets `near`, `axis` and `excess` of the bend; returns its rotation vector. */
static inline Vector follow_turn(Bend *bend, Vector last)
{
    Quaternion q = bend->rotation;
    Vector sine = vector(q.x, q.y, q.z);
    double size = value_of(norm(sine));
    double from = value_of(norm(last));
    Vector axis = vector(1.0, 0.0, 0.0);
    if (size >= LEAST_SINE) {
        axis = scale(1.0 / norm(sine), sine);
    } else if (from > 0.0) {
        axis = scale(1.0 / from, last);
    }
    double along = value_of(dot(axis, last));
    real angle = size >= LEAST_SINE ? followed_angle(norm(sine), q.w, along)
                                    : nearest_turn(value_of(q.w) < 0.0 ? 2.0 * half_turn : 0.0, along);
    if (value_of(angle) < 0.0) {
        angle = -angle;
        axis = scale(-1.0, axis);
    }
    if (value_of(angle) > half_turn) {
        bend->near = quaternion(0.0, axis.x, axis.y, axis.z);
        bend->axis = axis;
        bend->excess = angle - half_turn;
    } else if (value_of(q.w) < 0.0) {
        bend->near = bend->rotation = quaternion(-q.w, -q.x, -q.y, -q.z);
    }
    double turn = value_of(angle);
    return vector(turn * value_of(axis.x), turn * value_of(axis.y), turn * value_of(axis.z));
}

static inline ArmMotion arm_skin_motion(const ArmSkin *skin)
{
    ArmMotion motion = {.bend = arm_skin_bend(skin)};
    motion.twist = followed_twist(motion.bend.rotation, value_of(skin->last_twist));
    motion.spread = skin->twist_share * motion.twist;
    Quaternion untwisted = compose(motion.bend.rotation, rotation_about(vector(1.0, 0.0, 0.0), -motion.spread));
    motion.bend = bend_by(untwisted, motion.bend.gap);
    motion.turn = follow_turn(&motion.bend, skin->last_turn);
    return motion;
}

static inline void arm_skin_remember(ArmSkin *skin)
{
    ArmMotion motion = arm_skin_motion(skin);
    skin->last_turn = motion.turn;
    skin->last_twist = value_of(motion.twist);
}

/* At the start both go the shorter way. */
static inline void arm_skin_initialize(ArmSkin *skin)
{
    skin->last_turn = vector(0.0, 0.0, 0.0);
    skin->last_twist = 0.0;
    arm_skin_remember(skin);
}

#endif
