/* ArmSkin: the whole skin at once, in float32, a row of numbers per coordinate and no branches, so
 * that compilers turn the loops into vector instructions. What is equal for all vertices is
 * computed before, in double.
 *
 * At one weight every method is an affine map, of the point's rest position from the elbow:
 *
 *   linear blend        U + w C                                   C: the forearm's map less U,
 *   dual quaternions    U + (w (1 - w) S + w^2 C) / N             the upper arm's
 *
 * with N = 1 - 2 w (1 - w) (1 - c) the square of the blended quaternion's norm, c and t the real
 * and vector part of the quaternion from the upper arm to the forearm, and S the swing at which the
 * blend sets out, 2 t x R_u y + c gap + gap x t. At rest C and S are exactly zero and the mesh
 * comes back to the bit.
 *
 * Normals are exact: n goes to cof(J) n, J the Jacobian of the deformation. As the weight changes
 * along the bone at a slope s, J is the map's matrix plus s times its rate in w, applied to the
 * point, in the column of x.
 */
#include "equations.h"

#include <float.h>

typedef struct Float3 {
    float x, y, z;
} Float3;

/* A matrix by its columns, and a shift: y -> y.x x + y.y y + y.z z + shift. */
typedef struct AffineMap {
    Float3 x, y, z, shift;
} AffineMap;

/* The motion of the two bones, in the world. */
typedef struct SkinMotion {
    AffineMap upper_arm; /* U */
    AffineMap forearm;   /* U + C, its shift left out */
    AffineMap change;    /* C */
    AffineMap swing;     /* S */
    float versine;       /* 1 - c */
} SkinMotion;

static Float3 to_float(Quaternion axes, Vector v)
{
    Vector turned = rotate(axes, v);
    Float3 f = {(float)turned.x, (float)turned.y, (float)turned.z};
    return f;
}

static SkinMotion skin_motion(const ArmSkin *skin)
{
    Bend bend = shorter_bend(arm_skin_bend(skin));
    Quaternion axes = normalized(skin->upper_arm_orientation);
    Quaternion q = bend.rotation;
    Vector t = vector(q.x, q.y, q.z);
    Vector x = vector(1.0, 0.0, 0.0);
    Vector y = vector(0.0, 1.0, 0.0);
    Vector z = vector(0.0, 0.0, 1.0);
    Vector shoulder = rotate_back(axes, skin->upper_arm_position);
    Vector slide = add_scaled(cross(bend.gap, t), q.w, bend.gap);
    SkinMotion motion = {
        .upper_arm = {to_float(axes, x), to_float(axes, y), to_float(axes, z),
                      to_float(axes, add(shoulder, arm_skin_elbow(skin)))},
        .forearm = {to_float(axes, rotate(q, x)), to_float(axes, rotate(q, y)), to_float(axes, rotate(q, z)), {0}},
        .change = {to_float(axes, subtract(rotate(q, x), x)), to_float(axes, subtract(rotate(q, y), y)),
                   to_float(axes, subtract(rotate(q, z), z)), to_float(axes, bend.gap)},
        .swing = {to_float(axes, scale(2.0, cross(t, x))), to_float(axes, scale(2.0, cross(t, y))),
                  to_float(axes, scale(2.0, cross(t, z))), to_float(axes, slide)},
        .versine = (float)(1.0 - q.w),
    };
    return motion;
}

static inline Float3 times(float s, Float3 a)
{
    Float3 f = {s * a.x, s * a.y, s * a.z};
    return f;
}

/* a + s b */
static inline Float3 plus_scaled(Float3 a, float s, Float3 b)
{
    Float3 f = {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
    return f;
}

static inline Float3 across(Float3 a, Float3 b)
{
    Float3 f = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return f;
}

/* The shift comes last, so that a small motion of a distant point loses no more than its rounding. */
static inline Float3 apply(AffineMap map, Float3 v)
{
    Float3 sum = plus_scaled(plus_scaled(times(v.x, map.x), v.y, map.y), v.z, map.z);
    return plus_scaled(sum, 1.0f, map.shift);
}

static inline AffineMap map_times(float s, AffineMap a)
{
    AffineMap map = {times(s, a.x), times(s, a.y), times(s, a.z), times(s, a.shift)};
    return map;
}

static inline AffineMap map_plus_scaled(AffineMap a, float s, AffineMap b)
{
    AffineMap map = {plus_scaled(a.x, s, b.x), plus_scaled(a.y, s, b.y), plus_scaled(a.z, s, b.z),
                     plus_scaled(a.shift, s, b.shift)};
    return map;
}

/* U + s C: of the two forms of a mean, that which rounds least for the matrix, and that which
 * returns to the bit for the shift. */
static inline AffineMap toward_forearm(SkinMotion motion, float s)
{
    AffineMap rest = map_times(1.0f - s, motion.upper_arm);
    AffineMap map = map_plus_scaled(rest, s, motion.forearm);
    map.shift = plus_scaled(motion.upper_arm.shift, s, motion.change.shift);
    return map;
}

/* A method: its map at a weight, and the derivative of that map by the weight. */
typedef AffineMap SkinMap(SkinMotion motion, float weight);

static inline AffineMap linear_blend_map(SkinMotion motion, float w)
{
    return toward_forearm(motion, w);
}

static inline AffineMap linear_blend_rate(SkinMotion motion, float w)
{
    (void)w;
    return motion.change;
}

static inline float dual_inverse_square(SkinMotion motion, float w)
{
    return 1.0f / (1.0f - 2.0f * w * (1.0f - w) * motion.versine);
}

static inline AffineMap dual_quaternion_map(SkinMotion motion, float w)
{
    float inverse = dual_inverse_square(motion, w);
    return map_plus_scaled(toward_forearm(motion, w * w * inverse), w * (1.0f - w) * inverse, motion.swing);
}

/* d/dw of w (1 - w) / N is (1 - 2 w) / N^2, of w^2 / N it is 2 w (1 - w (1 - c)) / N^2. */
static inline AffineMap dual_quaternion_rate(SkinMotion motion, float w)
{
    float inverse = dual_inverse_square(motion, w);
    float swing = (1.0f - 2.0f * w) * inverse * inverse;
    float change = 2.0f * w * (1.0f - w * motion.versine) * inverse * inverse;
    return map_plus_scaled(map_times(swing, motion.swing), change, motion.change);
}

static inline void deform_positions(SkinMotion motion, const ArmMesh *mesh, SkinMap *map_at, float *restrict out)
{
    size_t n = mesh->vertex_count;
    const float *restrict x = mesh->row[REST_X];
    const float *restrict y = mesh->row[REST_Y];
    const float *restrict z = mesh->row[REST_Z];
    const float *restrict weight = mesh->row[WEIGHT];
    for (size_t i = 0; i < n; i++) {
        Float3 rest = {x[i], y[i], z[i]};
        Float3 deformed = apply(map_at(motion, weight[i]), rest);
        out[i] = deformed.x;
        out[n + i] = deformed.y;
        out[2 * n + i] = deformed.z;
    }
}

static inline void deform_normals(SkinMotion motion, const ArmMesh *mesh, SkinMap *map_at, SkinMap *rate_at,
                                  float *restrict out)
{
    size_t n = mesh->vertex_count;
    const float *restrict x = mesh->row[REST_X];
    const float *restrict y = mesh->row[REST_Y];
    const float *restrict z = mesh->row[REST_Z];
    const float *restrict weight = mesh->row[WEIGHT];
    const float *restrict slope = mesh->row[WEIGHT_SLOPE];
    const float *restrict normal_x = mesh->row[NORMAL_X];
    const float *restrict normal_y = mesh->row[NORMAL_Y];
    const float *restrict normal_z = mesh->row[NORMAL_Z];
    for (size_t i = 0; i < n; i++) {
        Float3 rest = {x[i], y[i], z[i]};
        AffineMap jacobian = map_at(motion, weight[i]);
        jacobian.x = plus_scaled(jacobian.x, slope[i], apply(rate_at(motion, weight[i]), rest));
        Float3 normal = times(normal_x[i], across(jacobian.y, jacobian.z));
        normal = plus_scaled(normal, normal_y[i], across(jacobian.z, jacobian.x));
        normal = plus_scaled(normal, normal_z[i], across(jacobian.x, jacobian.y));
        /* The smallest normal number stands in for the length of a normal that has none. */
        float square = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
        float inverse = 1.0f / sqrtf(square + FLT_MIN);
        out[i] = inverse * normal.x;
        out[n + i] = inverse * normal.y;
        out[2 * n + i] = inverse * normal.z;
    }
}

/* The rigid method is the linear blend with weights of 0 and 1. */
static void arm_skin_vertices(const ArmSkin *skin, const ArmMesh *mesh, float *out)
{
    SkinMotion motion = skin_motion(skin);
    if (skin->method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        deform_positions(motion, mesh, dual_quaternion_map, out);
    } else {
        deform_positions(motion, mesh, linear_blend_map, out);
    }
}

static void arm_skin_normals(const ArmSkin *skin, const ArmMesh *mesh, float *out)
{
    SkinMotion motion = skin_motion(skin);
    if (skin->method == ARM_SKIN_METHOD_DUAL_QUATERNION) {
        deform_normals(motion, mesh, dual_quaternion_map, dual_quaternion_rate, out);
    } else {
        deform_normals(motion, mesh, linear_blend_map, linear_blend_rate, out);
    }
}
