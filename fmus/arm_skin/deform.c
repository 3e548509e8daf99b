/* ArmSkin: the whole skin at once. Rows of numbers and no branches in the loops, so that compilers
 * turn them into vector instructions, the widest that the processor has.
 */
#include "instruction_sets.h"
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

IN_EVERY_INSTRUCTION_SET(deform, (int64_t method, SkinRow row, const SkinMotion *motion, const ArmMesh *mesh, float *out),
                         deform_method(method, row, motion, false, mesh, out))

/* Beyond half a turn: seldom, so that no wide copies are kept of it. */
static void deform_wound(int64_t method, SkinRow row, const SkinMotion *motion, const ArmMesh *mesh, float *out)
{
    deform_method(method, row, motion, true, mesh, out);
}

static void arm_skin_deform(const ArmSkin *skin, const ArmMesh *mesh, SkinRow row, float *out)
{
    ArmMotion pose = arm_skin_motion(skin);
    Skinning skinning = arm_skin_skinning(skin, mesh, pose.bend);
    SkinMotion motion = skin_motion_of(skin, pose.bend, skinning.widening, pose.spread);
    if (motion.excess > 0.0f) {
        deform_wound(skin->method, row, &motion, mesh, out);
    } else {
        deform[widest_instruction_set()](skin->method, row, &motion, mesh, out);
    }
}
