/* ArmSkin: what the deformation does to the skin around the elbow.
 *
 * On `real`, so that the measures can be differentiated by the complex step; where elements
 * compete, `value_of` picks the one that counts. A ring has one weight, so every method maps it
 * by one affine map: three points carry all its vertices. Outside the blend zone the skin moves
 * rigidly and there is nothing to measure.
 */
#ifndef ARM_SKIN_MEASURES_H
#define ARM_SKIN_MEASURES_H

#include "follow.h"
#include "mesh.h"

/* Vertex k of a deformed ring is center + cosine[k] first + sine[k] second. */
typedef struct RingFrame {
    Vector center, first, second;
} RingFrame;

typedef struct DeformedRing {
    RingFrame frame;
    Vector point[RING_VERTICES + 1]; /* first vertex repeated */
} DeformedRing;

/* What a method needs to know of the pose. */
typedef struct Skinning {
    int64_t method;
    Bend bend;
    double half_width; /* of the blend zone, m */
    real widening;
} Skinning;

/* How much wider the middle of the blend zone is made, so that its volume stays: with a = (1 + v g)^2
 * the area of a section over that at rest, g its share of the widening and d how far it is drawn in,
 * a (1 - d dphi/dx) is swept per length, which is to be 1 on average. Beyond half a turn as at it. */
static inline real section_widening(Bend bend, const ArmMesh *mesh)
{
    Quaternion q = bend.near;
    Vector across = cross(vector(q.x, q.y, q.z), vector(1.0, 0.0, 0.0));
    real draw = dot(across, across);
    real lost = 0.0, once = 0.0, twice = 0.0;
    for (size_t i = 0; i < ZONE_NODES; i++) {
        const ZoneNode *node = &mesh->node[i];
        real share = widening_at(node->weight);
        real turn = draw * draw_at(node->weight) / (1.0 - 2.0 * node->weight * (1.0 - node->weight) * (1.0 - q.w));
        real kept = node->length - node->weight_step * turn;
        lost += node->area * node->weight_step * turn;
        once += node->area * share * kept;
        twice += node->area * share * share * kept;
    }
    return lost / (once + sqrt(once * once + twice * lost));
}

static inline Skinning arm_skin_skinning(const ArmSkin *skin, const ArmMesh *mesh, Bend bend)
{
    bool compensated = skin->method == ARM_SKIN_METHOD_COMPENSATED;
    Skinning skinning = {skin->method, bend, value_of(skin->blend_half_width), 0.0};
    skinning.widening = compensated ? section_widening(bend, mesh) : 0.0;
    return skinning;
}

/* `center`: of rotation. */
static inline Vector arm_skin_point(const Skinning *skinning, double weight, Vector center, Vector point)
{
    switch (skinning->method) {
    case ARM_SKIN_METHOD_HINGE: return hinge_point(skinning->bend, weight, point);
    case ARM_SKIN_METHOD_DUAL_QUATERNION: return dual_quaternion_point(skinning->bend, weight, point);
    case ARM_SKIN_METHOD_CENTER_OF_ROTATION:
        return center_of_rotation_point(skinning->bend, weight, center, point);
    case ARM_SKIN_METHOD_COMPENSATED:
        return compensated_point(skinning->bend, weight, skinning->half_width, skinning->widening, point);
    default: return linear_blend_point(skinning->bend, weight, point);
    }
}

static inline void deform_ring(const Skinning *skinning, const ArmMesh *mesh, size_t index, DeformedRing *deformed)
{
    const ArmRing *ring = &mesh->rings[index];
    Vector turns_about = vector(ring->center, 0.0, 0.0);
    Vector center = arm_skin_point(skinning, ring->weight, turns_about, vector(ring->x, 0.0, 0.0));
    Vector on_first = arm_skin_point(skinning, ring->weight, turns_about, vector(ring->x, ring->radius, 0.0));
    Vector on_second = arm_skin_point(skinning, ring->weight, turns_about, vector(ring->x, 0.0, ring->radius));
    RingFrame frame = {center, subtract(on_first, center), subtract(on_second, center)};
    deformed->frame = frame;
    for (size_t k = 0; k <= RING_VERTICES; k++) {
        Vector along = add_scaled(center, mesh->cosine[k], frame.first);
        deformed->point[k] = add_scaled(along, mesh->sine[k], frame.second);
    }
}

/* Six times the volume between the elbow's point and a ring's plane polygon. */
static inline real ring_cone(const ArmMesh *mesh, RingFrame frame)
{
    return 2.0 * mesh->unit_ring_area * dot(frame.center, cross(frame.first, frame.second));
}

typedef struct Band {
    real volume; /* six times the volume between the elbow's point and the band's triangles */
    size_t inverted;
} Band;

/* The triangles between two neighbouring rings. One is inverted where its normal points against
 * the outward direction of its middle, turned as the blended quaternion turns the band. */
static inline Band measure_band(const ArmMesh *mesh, Quaternion turn, const DeformedRing *before,
                                const DeformedRing *after)
{
    Band band = {0.0, 0};
    Vector first = rotate(turn, vector(0.0, 1.0, 0.0));
    Vector second = rotate(turn, vector(0.0, 0.0, 1.0));
    for (size_t k = 0; k < RING_VERTICES; k++) {
        Diagonal split = band_diagonal(k);
        Vector first_corner = before->point[k];
        Vector second_corner = after->point[k];
        Vector first_normal = cross(subtract(before->point[k + 1], first_corner),
                                    subtract(after->point[split.after], first_corner));
        Vector second_normal = cross(subtract(before->point[split.before], second_corner),
                                     subtract(after->point[k + 1], second_corner));
        Vector outward = add(scale(mesh->cosine[k] + mesh->cosine[k + 1], first),
                             scale(mesh->sine[k] + mesh->sine[k + 1], second));
        band.volume += dot(first_corner, first_normal) + dot(second_corner, second_normal);
        band.inverted += (size_t)(value_of(dot(first_normal, outward)) < 0.0);
        band.inverted += (size_t)(value_of(dot(second_normal, outward)) < 0.0);
    }
    return band;
}

static inline real edge_growth(Vector edge, double rest_length)
{
    return norm(edge) - rest_length;
}

/* The largest growth of an edge between two neighbouring rings, if it is more than `largest`. */
static inline real largest_growth(const ArmMesh *mesh, size_t first_ring, const DeformedRing *before,
                                  const DeformedRing *after, real largest)
{
    const ArmRing *rest = &mesh->rings[first_ring];
    double length = rest[1].x - rest[0].x;
    double straight = hypot(length, rest[1].radius - rest[0].radius);
    for (size_t k = 0; k < RING_VERTICES; k++) {
        Diagonal split = band_diagonal(k);
        double y = rest[1].radius * mesh->cosine[split.after] - rest[0].radius * mesh->cosine[split.before];
        double z = rest[1].radius * mesh->sine[split.after] - rest[0].radius * mesh->sine[split.before];
        double diagonal = sqrt(length * length + y * y + z * z);
        real straight_growth = edge_growth(subtract(after->point[k], before->point[k]), straight);
        real diagonal_growth = edge_growth(subtract(after->point[split.after], before->point[split.before]), diagonal);
        largest = value_of(straight_growth) > value_of(largest) ? straight_growth : largest;
        largest = value_of(diagonal_growth) > value_of(largest) ? diagonal_growth : largest;
    }
    return largest;
}

static inline void measure_rings(ArmSkin *skin, const ArmMesh *mesh, Skinning skinning)
{
    Bend bend = skinning.bend;
    DeformedRing pair[2];
    size_t inverted = 0;
    real gap = -INFINITY;

    deform_ring(&skinning, mesh, mesh->zone_start, &pair[0]);
    real volume = -ring_cone(mesh, pair[0].frame);
    real smallest = 1.0; /* the rings outside the zone */
    for (size_t i = mesh->zone_start; i < mesh->zone_end; i++) {
        const ArmRing *ring = &mesh->rings[i + 1];
        const DeformedRing *before = &pair[(i - mesh->zone_start) % 2];
        DeformedRing *after = &pair[(i + 1 - mesh->zone_start) % 2];
        deform_ring(&skinning, mesh, i + 1, after);

        real section = norm(cross(after->frame.first, after->frame.second)) / (ring->radius * ring->radius);
        smallest = value_of(section) < value_of(smallest) ? section : smallest;
        Quaternion turn = blended_rotation(bend, 0.5 * (ring[-1].weight + ring->weight));
        Band band = measure_band(mesh, turn, before, after);
        volume += band.volume;
        inverted += band.inverted;
        if (i + 1 == mesh->elbow || i == mesh->elbow) {
            gap = largest_growth(mesh, i, before, after, gap);
        }
        if (i + 1 == mesh->zone_end) {
            volume += ring_cone(mesh, after->frame);
        }
    }
    skin->blend_volume_ratio = volume / (6.0 * mesh->zone_volume);
    skin->minimum_section_ratio = smallest;
    skin->elbow_gap = gap;
    skin->fold_fraction = (double)inverted / (double)(2 * mesh->vertex_count - UNUSED_TRIANGLES);
}

#include "triangles.h"

static inline void arm_skin_measures(ArmSkin *skin, const void *workspace)
{
    const ArmMesh *mesh = workspace;
    Bend bend = arm_skin_motion(skin).bend;
    Skinning skinning = arm_skin_skinning(skin, mesh, bend);
    if (mesh->triangle_count) {
        measure_triangles(skin, mesh, skinning);
    } else {
        measure_rings(skin, mesh, skinning);
    }
}

#endif
