/* ArmSkin: the whole skin at once. Rows of numbers and no branches in the loops, so that compilers
 * turn them into vector instructions; where GCC or Clang compile for x86-64, for the widest that the
 * processor has, found at run time. No sum is reordered and no product fused, so all give the same
 * bits. ULNA_PLAIN leaves the wide ones out.
 */
#include "motion.h"
#include "rings.h"
#include "vertices.h"

typedef enum SkinRow { SKIN_VERTICES, SKIN_NORMALS } SkinRow;

INLINED void deform_by(int method, SkinRow row, const SkinMotion *motion, bool wound, bool twisted, const ArmMesh *mesh,
                       float *out)
{
    if (mesh->triangle_count && row == SKIN_VERTICES) {
        each_vertex(method, motion, wound, twisted, mesh, out);
    } else if (mesh->triangle_count) {
        each_normal(method, motion, wound, twisted, mesh, out);
    } else if (row == SKIN_VERTICES) {
        ring_vertices(method, motion, wound, twisted, mesh, out);
    } else {
        ring_normals(method, motion, wound, twisted, mesh, out);
    }
}

#define DEFORM_CASE(METHOD)                                             \
    case ARM_SKIN_METHOD_##METHOD:                                      \
        deform_by(ARM_SKIN_METHOD_##METHOD, row, motion, wound, twisted, mesh, out); \
        break;

/* The rigid method is the linear blend with weights of 0 and 1. */
INLINED void deform_twisted(int64_t method, SkinRow row, const SkinMotion *motion, bool wound, bool twisted,
                            const ArmMesh *mesh, float *out)
{
    switch (method) {
    DEFORM_CASE(HINGE)
    DEFORM_CASE(DUAL_QUATERNION)
    DEFORM_CASE(CENTER_OF_ROTATION)
    DEFORM_CASE(COMPENSATED)
    default: deform_by(ARM_SKIN_METHOD_LINEAR_BLEND, row, motion, wound, twisted, mesh, out); break;
    }
    each_follower(row == SKIN_NORMALS, motion, twisted, mesh, out);
}

INLINED void deform_method(int64_t method, SkinRow row, const SkinMotion *motion, bool wound, const ArmMesh *mesh, float *out)
{
    if (motion->spread == 0.0f) {
        deform_twisted(method, row, motion, wound, false, mesh, out);
    } else {
        deform_twisted(method, row, motion, wound, true, mesh, out);
    }
}

typedef void Deform(int64_t method, SkinRow row, const SkinMotion *motion, const ArmMesh *mesh, float *out);

static void deform_plain(int64_t method, SkinRow row, const SkinMotion *motion, const ArmMesh *mesh, float *out)
{
    deform_method(method, row, motion, false, mesh, out);
}

/* Beyond half a turn: seldom, so that no wide copies are kept of it. */
static void deform_wound(int64_t method, SkinRow row, const SkinMotion *motion, const ArmMesh *mesh, float *out)
{
    deform_method(method, row, motion, true, mesh, out);
}

#if defined(__x86_64__) && defined(__GNUC__) && !defined(ULNA_PLAIN)
#if defined(__clang__)
#define WIDEST "avx512f,avx512vl,avx512dq"
#else
#define WIDEST "avx512f,avx512vl,avx512dq,prefer-vector-width=512"
#endif

__attribute__((target("avx2"))) static void deform_avx2(int64_t method, SkinRow row, const SkinMotion *motion,
                                                        const ArmMesh *mesh, float *out)
{
    deform_method(method, row, motion, false, mesh, out);
}

__attribute__((target(WIDEST))) static void deform_avx512(
    int64_t method, SkinRow row, const SkinMotion *motion, const ArmMesh *mesh, float *out)
{
    deform_method(method, row, motion, false, mesh, out);
}

static Deform *widest_deform(void)
{
    bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
    return wide ? deform_avx512 : __builtin_cpu_supports("avx2") ? deform_avx2 : deform_plain;
}
#else
static Deform *widest_deform(void)
{
    return deform_plain;
}
#endif

static void arm_skin_deform(const ArmSkin *skin, const ArmMesh *mesh, SkinRow row, float *out)
{
    ArmMotion pose = arm_skin_motion(skin);
    Skinning skinning = arm_skin_skinning(skin, mesh, pose.bend);
    SkinMotion motion = skin_motion_of(skin, pose.bend, skinning.widening, pose.spread);
    Deform *deform = motion.excess > 0.0f ? deform_wound : widest_deform();
    deform(skin->method, row, &motion, mesh, out);
}
