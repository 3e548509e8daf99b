/* ArmSkin: the measures of a mesh that is no stack of rings, by its triangles.
 *
 * The skin around the elbow is the triangles that bend. What lies beyond them moves with one bone or
 * the other about the elbow, so the cones from there to both ends keep their volume, and the change
 * of the cones to the triangles is that of the volume between: with the bones' elbows taken as one.
 */
#ifndef ARM_SKIN_TRIANGLES_H
#define ARM_SKIN_TRIANGLES_H

enum { SECTIONS = 33 };

typedef struct BentTriangle {
    Vector corner[3];
    Vector rest[3];
    double weight[3];
} BentTriangle;

static inline BentTriangle bend_triangle(const Skinning *skinning, const ArmMesh *mesh, size_t triangle)
{
    BentTriangle bent;
    for (size_t k = 0; k < 3; k++) {
        MeshCorner corner = mesh_corner(mesh, triangle, k);
        size_t v = (size_t)mesh->triangle[3 * triangle + k];
        Vector center = vector((double)mesh->vertex_row[VERTEX_CENTER_X][v], (double)mesh->vertex_row[VERTEX_CENTER_X + 1][v],
                               (double)mesh->vertex_row[VERTEX_CENTER_X + 2][v]);
        bent.weight[k] = corner.weight;
        bent.rest[k] = vector(corner.x, corner.y, corner.z);
        bent.corner[k] = arm_skin_point(skinning, corner.weight, center, bent.rest[k]);
    }
    return bent;
}

static inline Vector area_of(const Vector corner[3])
{
    return cross(subtract(corner[1], corner[0]), subtract(corner[2], corner[0]));
}

/* The largest growth of an edge that crosses the middle of the blend, if it is more than `largest`. */
static inline real crossing_growth(const BentTriangle *bent, real largest)
{
    for (size_t k = 0; k < 3; k++) {
        size_t next = (k + 1) % 3;
        real growth = norm(subtract(bent->corner[next], bent->corner[k])) - norm(subtract(bent->rest[next], bent->rest[k]));
        bool crosses = (bent->weight[k] < 0.5) != (bent->weight[next] < 0.5);
        largest = crosses && value_of(growth) > value_of(largest) ? growth : largest;
    }
    return largest;
}

/* Sections at equal steps of the weight: at one weight, a map makes all of them smaller alike. */
static inline real smallest_section(const Skinning *skinning)
{
    Vector none = vector(0.0, 0.0, 0.0);
    real smallest = 1.0;
    for (int i = 0; i < SECTIONS; i++) {
        double weight = (double)i / (SECTIONS - 1);
        weight = skinning->method == ARM_SKIN_METHOD_RIGID ? 0.0 : weight;
        Vector middle = arm_skin_point(skinning, weight, none, none);
        Vector first = subtract(arm_skin_point(skinning, weight, none, vector(0.0, 1.0, 0.0)), middle);
        Vector second = subtract(arm_skin_point(skinning, weight, none, vector(0.0, 0.0, 1.0)), middle);
        real section = norm(cross(first, second));
        smallest = value_of(section) < value_of(smallest) ? section : smallest;
    }
    return smallest;
}

static inline void measure_triangles(ArmSkin *skin, const ArmMesh *mesh, Skinning skinning)
{
    Skinning joined = skinning;
    joined.bend.gap = vector(0.0, 0.0, 0.0);
    size_t inverted = 0;
    real gap = -INFINITY, gain = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (triangle_bends(mesh, t)) {
            BentTriangle bent = bend_triangle(&skinning, mesh, t), whole = bend_triangle(&joined, mesh, t);
            double weight = (bent.weight[0] + bent.weight[1] + bent.weight[2]) / 3.0;
            Vector outward = rotate(blended_rotation(skinning.bend, weight), area_of(bent.rest));
            inverted += (size_t)(value_of(dot(area_of(bent.corner), outward)) < 0.0);
            gain += dot(whole.corner[0], area_of(whole.corner)) - dot(bent.rest[0], area_of(bent.rest));
            gap = crossing_growth(&bent, gap);
        }
    }
    skin->blend_volume_ratio = 1.0 + gain / (6.0 * mesh->zone_volume);
    skin->minimum_section_ratio = smallest_section(&skinning);
    skin->elbow_gap = value_of(gap) > -INFINITY ? gap : 0.0;
    skin->fold_fraction = (double)inverted / (double)mesh->triangle_count;
}

#endif
