// The motion of the bones against each other, and of one vertex of the skin by the methods that blend: the points
// of the measures in `real`, and the kernels of deform.c, whose float32 stands for real numbers here.
#define float Real
#define restrict
#define sqrtf sqrt
#include "mesh.h"

// The measures take the shorter of the two ways, q or -q; what follows holds for both.
static Bend shorter_bend(Bend bend)
{
    return bend;
}

#include "deform.c"
#undef float

static Bend bend_of(Lift &lift)
{
    ArmSkin skin = fields(lift);
    return arm_skin_bend(&skin);
}

typedef void Kernel(const ArmSkin *skin, const ArmMesh *mesh, Real *out);

static Vector vertex_of(Lift &lift, Kernel *kernel, int64_t method)
{
    ArmSkin skin = fields(lift);
    skin.method = method;
    Vector point = lift.symbols<Vector>("point");
    Vector normal = lift.symbols<Vector>("rest_normal");
    Real weight = lift.symbols<Real>("weight");
    Real slope = lift.symbols<Real>("weight_slope");
    ArmMesh mesh = {};
    mesh.vertex_count = 1;
    const Real *rows[MESH_ROWS] = {&point.x, &point.y, &point.z, &weight, &slope, &normal.x, &normal.y, &normal.z};
    std::copy(rows, rows + MESH_ROWS, mesh.row);
    Vector vertex;
    kernel(&skin, &mesh, &vertex.x);
    return vertex;
}

static void lift_functions()
{
    lift_function("bend_rotation", [](Lift &lift) { return bend_of(lift).rotation; });
    lift_function("bend_gap", [](Lift &lift) { return bend_of(lift).gap; });
    lift_function("linear_blend_point", [](Lift &lift) {
        Bend bend = bend_of(lift);
        Real weight = lift.symbols<Real>("weight");
        return linear_blend_point(bend, weight, lift.symbols<Vector>("point"));
    });
    lift_function("dual_quaternion_point", [](Lift &lift) {
        Bend bend = bend_of(lift);
        Real weight = lift.symbols<Real>("weight");
        return dual_quaternion_point(bend, weight, lift.symbols<Vector>("point"));
    });
    lift_function("linear_blend_vertex", [](Lift &lift) {
        return vertex_of(lift, arm_skin_vertices, ARM_SKIN_METHOD_LINEAR_BLEND);
    });
    lift_function("dual_quaternion_vertex", [](Lift &lift) {
        return vertex_of(lift, arm_skin_vertices, ARM_SKIN_METHOD_DUAL_QUATERNION);
    });
    lift_function("linear_blend_normal", [](Lift &lift) {
        return vertex_of(lift, arm_skin_normals, ARM_SKIN_METHOD_LINEAR_BLEND);
    });
    lift_function("dual_quaternion_normal", [](Lift &lift) {
        return vertex_of(lift, arm_skin_normals, ARM_SKIN_METHOD_DUAL_QUATERNION);
    });
}
