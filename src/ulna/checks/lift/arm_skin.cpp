// The motion of the bones against each other, and of one vertex of the skin by the methods that blend: the points
// of the measures in `real`, and the kernels of vertices.h and rings.h, whose float32 stands for real numbers here.
// A ring of radius 1 m on spokes of any length reaches every point.
#define float Real
#define restrict
#define sqrtf sqrt
#define fabsf fabs
#define copysignf copysign
#include "mesh.h"
#include "vertices.h"
#include "rings.h"
#undef float

static Bend bend_of(Lift &lift)
{
    ArmSkin skin = fields(lift);
    return arm_skin_bend(&skin);
}

static Vector point_of(Lift &lift, int method)
{
    ArmSkin skin = fields(lift);
    Bend bend = arm_skin_bend(&skin);
    Real weight = lift.symbols<Real>("weight");
    Vector point = lift.symbols<Vector>("point");
    switch (method) {
    case ARM_SKIN_METHOD_HINGE: return hinge_point(bend, weight, point);
    case ARM_SKIN_METHOD_DUAL_QUATERNION: return dual_quaternion_point(bend, weight, point);
    case ARM_SKIN_METHOD_CENTER_OF_ROTATION:
        return center_of_rotation_point(bend, weight, lift.symbols<Vector>("center"), point);
    case ARM_SKIN_METHOD_COMPENSATED:
        return compensated_point(bend, weight, skin.blend_half_width, lift.symbols<Real>("widening"), point);
    default: return linear_blend_point(bend, weight, point);
    }
}

static SkinMotion motion_of(Lift &lift)
{
    ArmSkin skin = fields(lift);
    return skin_motion_of(&skin, arm_skin_bend(&skin), lift.symbols<Real>("widening"), 0.0);
}

static Vector vertex_of(Lift &lift, int method, bool normals, Holder holder = FOLLOWS_BOTH)
{
    SkinMotion motion = motion_of(lift);
    Vector point = lift.symbols<Vector>("point"), normal = lift.symbols<Vector>("rest_normal");
    Vector gradient = lift.symbols<Vector>("weight_gradient");
    Vector center = lift.symbols<Vector>("center"), center_rate = lift.symbols<Vector>("center_rate");
    Real weight = lift.symbols<Real>("weight");
    Vector level = level_line(gradient, normal);
    const Real *rows[VERTEX_ROWS] = {
        &point.x, &point.y, &point.z,  &normal.x, &normal.y, &normal.z,      &weight,        &level.x,
        &level.y, &level.z, &center.x, &center.y, &center.z, &center_rate.x, &center_rate.y, &center_rate.z};
    VertexRun run = {0, 1, holder};
    ArmMesh mesh = {};
    mesh.vertex_count = 1;
    mesh.run_count = 1;
    mesh.run = &run;
    std::copy(rows, rows + VERTEX_ROWS, mesh.vertex_row);
    Vector vertex;
    (normals ? each_normal : each_vertex)(method, &motion, false, false, &mesh, &vertex.x);
    each_follower(normals, &motion, false, &mesh, &vertex.x);
    return vertex;
}

static Vector ring_of(Lift &lift, int method, bool normals)
{
    SkinMotion motion = motion_of(lift);
    Vector point = lift.symbols<Vector>("point"), normal = lift.symbols<Vector>("rest_normal");
    Vector gradient = lift.symbols<Vector>("weight_gradient");
    Vector center = lift.symbols<Vector>("center"), center_rate = lift.symbols<Vector>("center_rate");
    Real weight = lift.symbols<Real>("weight"), one = 1.0, none = 0.0;
    const Real *rows[RING_ROWS] = {&point.x,    &one,      &normal.x,      &normal.y, &weight,
                                   &gradient.x, &center.x, &center_rate.x, &none};
    ArmMesh mesh = {};
    mesh.vertex_count = RING_VERTICES;
    mesh.ring_count = 1;
    std::copy(rows, rows + RING_ROWS, mesh.ring_row);
    mesh.spoke_y[0] = point.y;
    mesh.spoke_z[0] = point.z;
    std::vector<Real> out(3 * RING_VERTICES);
    (normals ? ring_normals : ring_vertices)(method, &motion, false, false, &mesh, out.data());
    Vector vertex = {out[0], out[RING_VERTICES], out[2 * RING_VERTICES]};
    return vertex;
}

static void lift_method(const std::string &name, int method)
{
    lift_function(name + "_point", [=](Lift &lift) { return point_of(lift, method); });
    lift_function(name + "_vertex", [=](Lift &lift) { return vertex_of(lift, method, false); });
    lift_function(name + "_normal", [=](Lift &lift) { return vertex_of(lift, method, true); });
    lift_function(name + "_ring_vertex", [=](Lift &lift) { return ring_of(lift, method, false); });
    lift_function(name + "_ring_normal", [=](Lift &lift) { return ring_of(lift, method, true); });
}

static void lift_holder(const std::string &name, Holder holder)
{
    const int method = ARM_SKIN_METHOD_LINEAR_BLEND;
    lift_function(name + "_vertex", [=](Lift &lift) { return vertex_of(lift, method, false, holder); });
    lift_function(name + "_normal", [=](Lift &lift) { return vertex_of(lift, method, true, holder); });
}

static void lift_functions()
{
    lift_function("bend_rotation", [](Lift &lift) { return bend_of(lift).rotation; });
    lift_function("bend_gap", [](Lift &lift) { return bend_of(lift).gap; });
    lift_method("linear_blend", ARM_SKIN_METHOD_LINEAR_BLEND);
    lift_method("hinge", ARM_SKIN_METHOD_HINGE);
    lift_method("dual_quaternion", ARM_SKIN_METHOD_DUAL_QUATERNION);
    lift_method("center_of_rotation", ARM_SKIN_METHOD_CENTER_OF_ROTATION);
    lift_method("compensated", ARM_SKIN_METHOD_COMPENSATED);
    lift_holder("upper_arm", FOLLOWS_UPPER_ARM);
    lift_holder("forearm", FOLLOWS_FOREARM);
}
