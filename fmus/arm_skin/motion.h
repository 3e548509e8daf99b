/* ArmSkin: what a pose makes of the two bones, in float32, and what each method makes of a weight.
 *
 * At one weight w every method is an affine map of a rest point y, taken from the elbow:
 *
 *   y -> (1 - w) U z + w F z + (p K + q Q) (z - c) + shift + g gap + l slide
 *
 * U and F are the maps of upper arm and forearm; K = 2 U [t]x and Q = 2 U [t]x^2 turn as the blend
 * does at first and second order, t the vector part of the quaternion from the upper arm to the
 * forearm. For the linear blend p = q = 0; for the others p and q vanish at the ends of the blend,
 * so that F and U, which round least, remain; c is the centre of rotation. z is y, made wider by
 * `compensated` and drawn in. At rest F - U, p and q are exactly zero, and the mesh comes back to
 * the bit.
 */
#ifndef ARM_SKIN_MOTION_H
#define ARM_SKIN_MOTION_H

#include "equations.h"
#include "instruction_sets.h"

typedef struct Float3 {
    float x, y, z;
} Float3;

typedef struct Matrix3 {
    Float3 x, y, z; /* columns */
} Matrix3;

typedef struct SkinMotion {
    Matrix3 upper_arm, forearm, change; /* U, F, F - U */
    Matrix3 first, second;              /* K, Q */
    Float3 shift, rest_of_shift, gap, slide; /* the shift in two numbers: it is the largest */
    Float3 inward;       /* where sections are drawn in, in the axes of U */
    float cosine;        /* of half the turn, at most half a turn: the near turn */
    float sine_square;
    float first_end, second_end; /* F - U = first_end K + second_end Q */
    float excess;        /* beyond half a turn, rad */
    float widening;
    float spread;        /* twist along the forearm, rad */
    float spread_begin, spread_slope; /* where it begins, from the elbow, m; its share, 1/m */
    Matrix3 into_hinge, hinge; /* from the axes at rest to those of the turn, the first along it; from these to the world */
    Float3 hinge_gap, hinge_slide;
    float sine;                     /* of half the near turn */
    float full_cosine, full_sine; /* cosine - 1 and sine of all of it */
} SkinMotion;

/* What a method makes of a weight, or its derivative by the weight. */
typedef struct Share {
    float first, second; /* p, q */
    float gap, slide;    /* g, l */
    float width, inward; /* of a section; 1 and 0 but for `compensated` */
} Share;

typedef struct Shares {
    Share at, rate;
} Shares;

INLINED Float3 times(float s, Float3 a)
{
    Float3 f = {s * a.x, s * a.y, s * a.z};
    return f;
}

/* a + s b */
INLINED Float3 plus_scaled(Float3 a, float s, Float3 b)
{
    Float3 f = {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
    return f;
}

INLINED Float3 across(Float3 a, Float3 b)
{
    Float3 f = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return f;
}

INLINED Float3 carried(Matrix3 m, Float3 v)
{
    return plus_scaled(plus_scaled(times(v.x, m.x), v.y, m.y), v.z, m.z);
}

/* (1 - w) a + w b */
INLINED Float3 mean_of(Float3 a, Float3 b, float w)
{
    return plus_scaled(times(1.0f - w, a), w, b);
}

INLINED Matrix3 matrix_mean(Matrix3 a, Matrix3 b, float w)
{
    Matrix3 m = {mean_of(a.x, b.x, w), mean_of(a.y, b.y, w), mean_of(a.z, b.z, w)};
    return m;
}

INLINED Matrix3 matrix_plus(Matrix3 a, float s, Matrix3 b)
{
    Matrix3 m = {plus_scaled(a.x, s, b.x), plus_scaled(a.y, s, b.y), plus_scaled(a.z, s, b.z)};
    return m;
}

/* What rounding loses of a + b (Knuth). */
INLINED float sum_error(float a, float b)
{
    float sum = a + b;
    float part = sum - a;
    return (a - (sum - part)) + (b - part);
}

/* Sine and cosine, to a rounding or two, without a branch or a call: a quarter turn at a time, then
 * their series, whose rest is below 1e-8. */
INLINED void sine_and_cosine(float angle, float *sine, float *cosine)
{
    const float rounder = 12582912.0f; /* 1.5 2^23: adding it leaves whole numbers */
    float quarters = angle * 0.636619772f + rounder - rounder;
    float a = angle - quarters * 1.57079637f; /* and what float32 lacks of it */
    a += quarters * 4.37113883e-8f;
    float square = a * a;
    float s = a + a * square * (-1.6666667e-1f + square * (8.3333333e-3f + square * (-1.9841270e-4f + square * 2.7557319e-6f)));
    float c = 1.0f + square * (-0.5f + square * (4.1666667e-2f + square * (-1.3888889e-3f + square * 2.4801587e-5f)));
    float half = 0.5f * quarters;
    float odd = quarters - 2.0f * (half - 0.25f + rounder - rounder);
    float pair = half - 0.5f * odd;
    float opposite = pair - 2.0f * (0.5f * pair - 0.25f + rounder - rounder);
    float sign = 1.0f - 2.0f * opposite;
    *sine = sign * ((1.0f - odd) * s + odd * c);
    *cosine = sign * ((1.0f - odd) * c - odd * s);
}

/* p, q and their rates from those of the rotation alone: near turn b = (1 - w) + w (cosine, t). */
INLINED void turn_shares(const SkinMotion *motion, bool wound, float w, float inverse, Shares *shares)
{
    float first = w * (1.0f - w * (1.0f - motion->cosine)) * inverse;
    float second = w * w * inverse;
    float speed = inverse;
    if (wound) {
        float sine, cosine;
        sine_and_cosine(w * motion->excess, &sine, &cosine);
        float near_sine = 2.0f * first, near_cosine = 1.0f - 2.0f * second;
        first = 0.5f * (near_sine * cosine + near_cosine * sine);
        second = 0.5f * (1.0f - near_cosine * cosine + near_sine * sine);
        speed += 0.5f * motion->excess;
    }
    shares->at.first = first - w * motion->first_end;
    shares->at.second = second - w * motion->second_end;
    shares->rate.first = (1.0f - 2.0f * motion->sine_square * second) * speed - motion->first_end;
    shares->rate.second = 2.0f * first * speed - motion->second_end;
}

/* The square of a blended quaternion's norm is 1 - 2 w (1 - w) (1 - c); d/dw of w (1 - w) over it is
 * (1 - 2 w) over its square, of w^2 over it 2 w (1 - w (1 - c)) over its square. */
INLINED Shares shares_at(int method, const SkinMotion *motion, bool wound, float w)
{
    Shares shares = {{0.0f, 0.0f, w, 0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f}};
    if (method == ARM_SKIN_METHOD_LINEAR_BLEND) {
        return shares;
    }
    float both = w * (1.0f - w);
    float versine = 1.0f - motion->cosine;
    float inverse = 1.0f / (1.0f - 2.0f * both * versine);
    turn_shares(motion, wound, w, inverse, &shares);
    if (method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        shares.at.gap = w * w * inverse;
        shares.at.slide = both * inverse;
        shares.rate.gap = 2.0f * w * (1.0f - w * versine) * inverse * inverse;
        shares.rate.slide = (1.0f - 2.0f * w) * inverse * inverse;
    }
    if (method == ARM_SKIN_METHOD_COMPENSATED) {
        float lean = 1.0f - 2.0f * w;
        float bow = 1.0f + 3.0f * lean * lean;
        shares.at.width = 1.0f + 4.0f * motion->widening * both;
        shares.rate.width = 4.0f * motion->widening * lean;
        shares.at.inward = both * bow;
        shares.rate.inward = lean * (bow - 12.0f * both);
    }
    return shares;
}

/* The matrix of the map at a weight; the sections' width is left out. */
INLINED Matrix3 share_matrix(const SkinMotion *motion, const Share *at, float w)
{
    Matrix3 m = matrix_mean(motion->upper_arm, motion->forearm, w);
    return matrix_plus(matrix_plus(m, at->first, motion->first), at->second, motion->second);
}

INLINED Matrix3 share_matrix_rate(const SkinMotion *motion, const Share *rate)
{
    return matrix_plus(matrix_plus(motion->change, rate->first, motion->first), rate->second, motion->second);
}

static Float3 to_float(Quaternion axes, Vector v)
{
    Vector turned = rotate(axes, v);
    Float3 f = {(float)turned.x, (float)turned.y, (float)turned.z};
    return f;
}

static Matrix3 matrix_float(Quaternion axes, Vector x, Vector y, Vector z)
{
    Matrix3 m = {to_float(axes, x), to_float(axes, y), to_float(axes, z)};
    return m;
}

/* The axis of a turn may be any. From `side`, 1 or -1, it is no more than a right angle away; where there
 * is no turn, it is x. */
typedef struct HingeSide {
    double side, no_turn;
} HingeSide;

#ifdef __cplusplus
static HingeSide hinge_side(Vector t)
{
    (void)t;
    HingeSide side = {1.0, 0.0};
    return side;
}
#else
static HingeSide hinge_side(Vector t)
{
    HingeSide side = {t.z < 0.0 ? -1.0 : 1.0, dot(t, t) > 0.0 ? 0.0 : 1.0};
    return side;
}
#endif

/* What the vertices of an imported mesh need: axes of which the first is that of the turn (Duff et al., "Building an
 * orthonormal basis, revisited", 2017), and all of the turn as a complex number. */
static void set_hinge(SkinMotion *motion, Quaternion axes, Bend bend, Vector slide, HingeSide at)
{
    Vector t = vector(bend.near.x + at.no_turn, bend.near.y, bend.near.z);
    real length = norm(t), sine = length - at.no_turn, cosine = bend.near.w;
    Vector along = scale(1.0 / length, t);
    real share = -1.0 / (at.side + along.z);
    real skew = along.x * along.y * share;
    Vector first = vector(1.0 + at.side * along.x * along.x * share, at.side * skew, -at.side * along.x);
    Vector second = vector(skew, at.side + along.y * along.y * share, -along.y);
    real near_cosine = 1.0 - 2.0 * sine * sine, near_sine = 2.0 * sine * cosine;
    Matrix3 into_hinge = {{(float)along.x, (float)first.x, (float)second.x},
                          {(float)along.y, (float)first.y, (float)second.y},
                          {(float)along.z, (float)first.z, (float)second.z}};
    Float3 gap = {(float)dot(along, bend.gap), (float)dot(first, bend.gap), (float)dot(second, bend.gap)};
    Float3 slid = {(float)dot(along, slide), (float)dot(first, slide), (float)dot(second, slide)};
    motion->into_hinge = into_hinge;
    motion->hinge = matrix_float(axes, along, first, second);
    motion->hinge_gap = gap;
    motion->hinge_slide = slid;
    motion->sine = (float)sine;
    motion->full_cosine = (float)(near_cosine * cos(bend.excess) - near_sine * sin(bend.excess) - 1.0);
    motion->full_sine = (float)(near_sine * cos(bend.excess) + near_cosine * sin(bend.excess));
}

/* Of a bend that has been followed. */
static SkinMotion skin_motion_of(const ArmSkin *skin, Bend bend, real widening, real spread)
{
    Quaternion axes = normalized(skin->upper_arm_orientation);
    Quaternion q = bend.rotation;
    Vector t = vector(bend.near.x, bend.near.y, bend.near.z);
    Vector x = vector(1.0, 0.0, 0.0), y = vector(0.0, 1.0, 0.0), z = vector(0.0, 0.0, 1.0);
    Vector tx = scale(2.0, cross(t, x)), ty = scale(2.0, cross(t, y)), tz = scale(2.0, cross(t, z));
    Vector elbow = add(skin->upper_arm_position, rotate(axes, arm_skin_elbow(skin)));
    Vector inward = scale(SECTION_DRAW * skin->blend_half_width, cross(t, x));
    Vector slide = add_scaled(cross(bend.gap, t), bend.near.w, bend.gap);
    real full = bend.near.w + sin(bend.excess) * -0.5;
    real half = 0.5 + 0.5 * cos(bend.excess);
    SkinMotion motion = {
        .upper_arm = matrix_float(axes, x, y, z),
        .forearm = matrix_float(axes, rotate(q, x), rotate(q, y), rotate(q, z)),
        .change = matrix_float(axes, subtract(rotate(q, x), x), subtract(rotate(q, y), y), subtract(rotate(q, z), z)),
        .first = matrix_float(axes, tx, ty, tz),
        .second = matrix_float(axes, cross(t, tx), cross(t, ty), cross(t, tz)),
        .shift = {(float)elbow.x, (float)elbow.y, (float)elbow.z},
        .gap = to_float(axes, bend.gap),
        .slide = to_float(axes, slide),
        .inward = {(float)inward.x, (float)inward.y, (float)inward.z},
        .cosine = (float)bend.near.w,
        .sine_square = (float)dot(t, t),
        .first_end = (float)full,
        .second_end = (float)half,
        .excess = (float)bend.excess,
        .widening = (float)widening,
        .spread = (float)spread,
        .spread_begin = (float)skin->blend_half_width,
        .spread_slope = (float)(1.0 / (skin->forearm_length - skin->radius - skin->blend_half_width)),
    };
    Float3 rest = {(float)(elbow.x - (real)motion.shift.x), (float)(elbow.y - (real)motion.shift.y),
                   (float)(elbow.z - (real)motion.shift.z)};
    motion.rest_of_shift = rest;
    set_hinge(&motion, axes, bend, slide, hinge_side(t));
    return motion;
}

#endif
