/* ArmSkin: how thick the arm is along the bone, and how fast that changes. */
#include "equations.h"

/* Of the radius, at a share of the length from shoulder's to hand's end; between them Hermite's cubic
 * with no slope at the ends of each piece, so that the widest and narrowest places are these. After
 * the proportions of an adult's arm: girth of upper arm, elbow, forearm and wrist as 1 : .86 : .9 : .58. */
typedef struct ProfileKnot {
    double place, thickness;
} ProfileKnot;

static const ProfileKnot arm_profile[] = {
    {0.0, 1.0}, {0.20, 1.0}, {0.43, 0.86}, {0.53, 0.90}, {0.88, 0.58}, {1.0, 0.58},
};

enum { PROFILE_KNOTS = sizeof arm_profile / sizeof *arm_profile };

typedef struct Thickness {
    double radius; /* m */
    double slope;  /* along the bone */
} Thickness;

/* At a place from the elbow, m. */
static Thickness thickness_at(const ArmSkin *skin, double x)
{
    Thickness even = {skin->radius, 0.0};
    if (skin->profile == ARM_SKIN_PROFILE_CYLINDER) {
        return even;
    }
    double length = skin->upper_arm_length + skin->forearm_length;
    double place = fmin(fmax((x + skin->upper_arm_length) / length, 0.0), 1.0);
    size_t i = 0;
    while (i + 2 < PROFILE_KNOTS && place >= arm_profile[i + 1].place) {
        i++;
    }
    double width = arm_profile[i + 1].place - arm_profile[i].place;
    double rise = arm_profile[i + 1].thickness - arm_profile[i].thickness;
    double t = (place - arm_profile[i].place) / width;
    Thickness thickness = {skin->radius * (arm_profile[i].thickness + rise * t * t * (3.0 - 2.0 * t)),
                           skin->radius * rise * 6.0 * t * (1.0 - t) / (width * length)};
    return thickness;
}

/* The radius of the round end at the hand. */
static double hand_radius(const ArmSkin *skin)
{
    return thickness_at(skin, skin->forearm_length).radius;
}
