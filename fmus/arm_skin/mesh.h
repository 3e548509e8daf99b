/* ArmSkin: the mesh at rest, which follows from the parameters alone.
 *
 * The skin is a stack of rings of equal vertex count; vertex k of ring i has the number
 * i RING_VERTICES + k. All vertices of a ring lie in one plane across the bone, at one weight.
 * Nothing here is on `real`: the mesh is the same where the measures are differentiated.
 */
#ifndef ARM_SKIN_MESH_H
#define ARM_SKIN_MESH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RING_VERTICES = 32, UNUSED_TRIANGLES = 4, LEAST_RINGS = 16, ZONE_NODES = 24 };

typedef struct ArmRing {
    double x;                       /* along the bone, from the elbow, m */
    double radius;                  /* m */
    double normal_x, normal_radial; /* outward unit normal of the skin */
    double weight;                  /* share of the forearm */
    double weight_slope;            /* its derivative along x, 1/m */
    double center, center_rate;     /* of rotation, along x, m; its derivative by the weight */
    double spread;                  /* share of the twist along the forearm that turns it */
} ArmRing;

/* A place in the blend zone where integrals over it are taken; the zone has length and area 1. */
typedef struct ZoneNode {
    double weight;
    double length, weight_step; /* what the node stands for, of length and of weight */
    double area;                /* of the section at rest */
} ZoneNode;

/* One number per ring, all rings in a row: what the kernels stream through. */
typedef enum RingRow {
    RING_X, /* from the elbow */
    RING_RADIUS,
    RING_NORMAL_X,
    RING_NORMAL_RADIAL,
    RING_WEIGHT,
    RING_SLOPE,
    RING_CENTER,
    RING_CENTER_RATE,
    RING_SPREAD,
    RING_ROWS
} RingRow;

/* One number per vertex of a mesh that is no stack of rings. */
typedef enum VertexRow {
    VERTEX_X, /* from the elbow */
    VERTEX_NORMAL_X = VERTEX_X + 3,
    VERTEX_WEIGHT = VERTEX_NORMAL_X + 3,
    VERTEX_LEVEL_X, /* gradient of the weight x normal: along the line of equal weight */
    VERTEX_CENTER_X = VERTEX_LEVEL_X + 3,
    VERTEX_CENTER_RATE_X = VERTEX_CENTER_X + 3,
    VERTEX_ROWS = VERTEX_CENTER_RATE_X + 3
} VertexRow;

/* Whom all vertices of a run follow. */
typedef enum Holder { FOLLOWS_UPPER_ARM, FOLLOWS_FOREARM, FOLLOWS_BOTH } Holder;

typedef struct VertexRun {
    size_t begin, end;
    Holder holder;
} VertexRun;

enum { LEAST_RUN = 64 }; /* vertices; but for the last run */

typedef struct ArmMesh {
    size_t vertex_count, ring_count;
    size_t zone_start, elbow, zone_end; /* rings at elbow - h, elbow, elbow + h */
    double zone_volume;                 /* between the first and the last of them, m3 */
    double unit_ring_area;              /* of the polygon in a circle of radius 1 */
    double cosine[RING_VERTICES + 1], sine[RING_VERTICES + 1]; /* around a ring, first vertex repeated */
    ZoneNode node[ZONE_NODES];
    const ArmRing *rings;
    const float *ring_row[RING_ROWS];
    const float *vertex_row[VERTEX_ROWS];
    size_t triangle_count; /* of a mesh that is no stack of rings; 0 where it is */
    const int32_t *triangle;
    size_t run_count;
    const VertexRun *run;
    float spoke_y[RING_VERTICES], spoke_z[RING_VERTICES]; /* cosine and sine again */
} ArmMesh;

typedef struct MeshCorner {
    double x, y, z, weight;
} MeshCorner;

static inline MeshCorner mesh_corner(const ArmMesh *mesh, size_t triangle, size_t k)
{
    size_t v = (size_t)mesh->triangle[3 * triangle + k];
    MeshCorner corner = {(double)mesh->vertex_row[VERTEX_X][v], (double)mesh->vertex_row[VERTEX_X + 1][v],
                         (double)mesh->vertex_row[VERTEX_X + 2][v], (double)mesh->vertex_row[VERTEX_WEIGHT][v]};
    return corner;
}

/* A triangle whose corners all follow one and the same bone moves as it does. */
static inline bool triangle_bends(const ArmMesh *mesh, size_t triangle)
{
    double sum = 0.0;
    for (size_t k = 0; k < 3; k++) {
        sum += mesh_corner(mesh, triangle, k).weight;
    }
    return sum > 0.0 && sum < 3.0;
}

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
