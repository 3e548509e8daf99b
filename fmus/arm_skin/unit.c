/* ArmSkin: the checks, the step, and what is computed when read. */
#include "unit.h"
#include "equations.h"
#include "mesh.c"
#include "deform.c"

#include <inttypes.h>
#include <math.h>

/* Whole rings; and outside the round ends both bones are longer than their half of the blend zone. */
static Status arm_skin_check(const ArmSkin *skin, Log *log)
{
    if (skin->imported) {
        return STATUS_OK;
    }
    if (skin->vertex_count < LEAST_RINGS * RING_VERTICES) {
        return report(log, STATUS_ERROR, "vertex_count = %" PRIu64 " is too coarse; allowed range: at least %d",
                      skin->vertex_count, LEAST_RINGS * RING_VERTICES);
    }
    uint64_t extra = skin->vertex_count % RING_VERTICES;
    if (extra != 0) {
        uint64_t below = skin->vertex_count - extra;
        return report(log, STATUS_ERROR,
                      "vertex_count = %" PRIu64 " is no whole number of rings; allowed range: multiples of %d, "
                      "the nearest of which are %" PRIu64 " and %" PRIu64,
                      skin->vertex_count, RING_VERTICES, below, below + RING_VERTICES);
    }
    double shorter = fmin(skin->upper_arm_length, skin->forearm_length);
    if (skin->radius >= shorter) {
        return report(log, STATUS_ERROR,
                      "radius = %g m leaves no straight part of a bone of %g m; allowed range: below the lengths "
                      "of both bones", skin->radius, shorter);
    }
    double room = shorter - skin->radius;
    if (skin->blend_half_width >= room) {
        return report(log, STATUS_ERROR,
                      "blend_half_width = %g m reaches into the round end of a bone of %g m; allowed range: below "
                      "the lengths of both bones less the radius, here %g m", skin->blend_half_width, shorter, room);
    }
    return STATUS_OK;
}

/* The skin follows its bones at once; a step remembers how far they are turned. */
static Status arm_skin_step(ArmSkin *skin, double step, Log *log)
{
    arm_skin_remember(skin);
    (void)step;
    (void)log;
    return STATUS_OK;
}

static void arm_skin_stream(const ArmSkin *skin, const void *workspace, size_t variable, void *destination)
{
    const ArmMesh *mesh = workspace;
    switch (variable) {
    case ARM_SKIN_VERTICES: arm_skin_deform(skin, mesh, SKIN_VERTICES, destination); break;
    case ARM_SKIN_NORMALS: arm_skin_deform(skin, mesh, SKIN_NORMALS, destination); break;
    case ARM_SKIN_MESH:
        arm_skin_deform(skin, mesh, SKIN_VERTICES, destination);
        arm_skin_deform(skin, mesh, SKIN_NORMALS, (float *)destination + 3 * mesh->vertex_count);
        break;
    case ARM_SKIN_TRIANGLES: fill_triangles(mesh, destination); break;
    case ARM_SKIN_WEIGHTS: fill_weights(mesh, destination); break;
    default: break;
    }
}
