/* ArmSkin: the mesh at rest, which follows from the parameters alone.
 *
 * The skin is a stack of rings of equal vertex count; vertex k of ring i has the number
 * i RING_VERTICES + k. All vertices of a ring lie in one plane across the bone, at one weight.
 * Nothing here is on `real`: the mesh is the same where the measures are differentiated.
 */
#ifndef ARM_SKIN_MESH_H
#define ARM_SKIN_MESH_H

#include <stddef.h>

enum { RING_VERTICES = 32, UNUSED_TRIANGLES = 4 };

typedef struct ArmRing {
    double x;                       /* along the bone, from the elbow, m */
    double radius;                  /* m */
    double normal_x, normal_radial; /* outward unit normal of the skin */
    double weight;                  /* share of the forearm */
    double weight_slope;            /* its derivative along x, 1/m */
} ArmRing;

/* One number per vertex, all vertices in a row: what the kernels stream through. */
typedef enum MeshRow {
    REST_X, /* from the elbow */
    REST_Y,
    REST_Z,
    WEIGHT,
    WEIGHT_SLOPE,
    NORMAL_X,
    NORMAL_Y,
    NORMAL_Z,
    MESH_ROWS
} MeshRow;

typedef struct ArmMesh {
    size_t vertex_count, ring_count;
    size_t zone_start, elbow, zone_end; /* rings at elbow - h, elbow, elbow + h */
    double zone_volume;                 /* between the first and the last of them, m3 */
    double unit_ring_area;              /* of the polygon in a circle of radius 1 */
    double cosine[RING_VERTICES + 1], sine[RING_VERTICES + 1]; /* around a ring, first vertex repeated */
    const ArmRing *rings;
    const float *row[MESH_ROWS];
} ArmMesh;

/* Between two neighbouring rings lie quadrilaterals k of corners k and k + 1 on each; each is cut
 * in two along a diagonal, left and right in turn so that the mesh is its own mirror image. */
typedef struct Diagonal {
    size_t before, after; /* its corner on the ring nearer to the shoulder, and on the other */
} Diagonal;

static inline Diagonal band_diagonal(size_t k)
{
    Diagonal diagonal = {k + k % 2, k + 1 - k % 2};
    return diagonal;
}

#endif
