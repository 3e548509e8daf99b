/* ArmSkin: optimised centres of rotation (Le and Hodgins 2016), made with the mesh.
 *
 * The centre of a vertex is the mean of the skin's points, each by its area and by how alike its
 * weights are to the vertex's. With two bones and weights w, v of the forearm (their equation 1)
 *
 *   s(w, v) = 2 w (1 - w) v (1 - v) exp(-((w - v) / sigma)^2)
 *
 * so the centre depends on w alone, and w (1 - w) divides out: it has limits at 0 and 1 as well.
 */
#ifndef ARM_SKIN_CENTERS_C
#define ARM_SKIN_CENTERS_C

#include "mesh.h"

#include <math.h>
#include <string.h>

/* Places in a table over the weight; between them cubic, its error of some 1e-10 of the zone. */
enum { CENTER_STEPS = 256 };

static const double likeness_width = 0.1; /* sigma */

typedef struct CenterNode {
    double place, rate; /* along the bone, m; its derivative by the weight */
} CenterNode;

/* The centre at a weight, over the bands between the zone's rings. */
static CenterNode center_node(const ArmMesh *mesh, double weight)
{
    double sum = 0.0, sum_rate = 0.0, moment = 0.0, moment_rate = 0.0;
    for (size_t i = mesh->zone_start; i < mesh->zone_end; i++) {
        const ArmRing *a = &mesh->rings[i];
        const ArmRing *b = a + 1;
        double other = 0.5 * (a->weight + b->weight);
        double place = 0.5 * (a->x + b->x);
        double area = (a->radius + b->radius) * hypot(b->x - a->x, b->radius - a->radius);
        double away = (weight - other) / likeness_width;
        double likeness = area * other * (1.0 - other) * exp(-away * away);
        double likeness_rate = -2.0 * away / likeness_width * likeness;
        sum += likeness;
        sum_rate += likeness_rate;
        moment += likeness * place;
        moment_rate += likeness_rate * place;
    }
    CenterNode node = {moment / sum, (moment_rate - moment / sum * sum_rate) / sum};
    return node;
}

/* Hermite's cubic through two nodes, `step` apart, at a share t of the way. */
static CenterNode between_nodes(CenterNode a, CenterNode b, double step, double t)
{
    double rise = b.place - a.place;
    double square = 3.0 * rise - step * (2.0 * a.rate + b.rate);
    double cube = step * (a.rate + b.rate) - 2.0 * rise;
    CenterNode node = {a.place + t * (step * a.rate + t * (square + t * cube)),
                       a.rate + t * (2.0 * square + t * 3.0 * cube) / step};
    return node;
}

static CenterNode center_between(const CenterNode *table, double weight)
{
    const double steps = CENTER_STEPS;
    double place = weight * steps;
    size_t k = place < steps ? (size_t)place : CENTER_STEPS - 1;
    return between_nodes(table[k], table[k + 1], 1.0 / steps, place - (double)k);
}

/* `rigid` has no weights in between, and no use for centres. */
static void set_centers(const ArmMesh *mesh, ArmRing *rings)
{
    CenterNode table[CENTER_STEPS + 1];
    bool blended = rings[mesh->elbow].weight < 1.0;
    for (size_t k = 0; k <= CENTER_STEPS; k++) {
        CenterNode none = {0.0, 0.0};
        table[k] = blended ? center_node(mesh, (double)k / (double)CENTER_STEPS) : none;
    }
    for (size_t i = 0; i < mesh->ring_count; i++) {
        CenterNode node = center_between(table, rings[i].weight);
        rings[i].center = node.place;
        rings[i].center_rate = node.rate;
    }
}

/* The skin of one range of weights. */
typedef struct WeightBin {
    double area, weight, place[3]; /* the means by v (1 - v) and area */
} WeightBin;

enum { WEIGHT_BINS = 1024 };

static void fill_bins(const ArmMesh *mesh, WeightBin *bins)
{
    memset(bins, 0, WEIGHT_BINS * sizeof *bins);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        MeshCorner a = mesh_corner(mesh, t, 0), b = mesh_corner(mesh, t, 1), c = mesh_corner(mesh, t, 2);
        double ab[3] = {b.x - a.x, b.y - a.y, b.z - a.z}, ac[3] = {c.x - a.x, c.y - a.y, c.z - a.z};
        double x = ab[1] * ac[2] - ab[2] * ac[1], y = ab[2] * ac[0] - ab[0] * ac[2], z = ab[0] * ac[1] - ab[1] * ac[0];
        double weight = (a.weight + b.weight + c.weight) / 3.0;
        double share = weight * (1.0 - weight) * sqrt(x * x + y * y + z * z);
        size_t k = (size_t)(weight * (WEIGHT_BINS - 1));
        WeightBin *bin = &bins[k < WEIGHT_BINS ? k : WEIGHT_BINS - 1];
        bin->area += share;
        bin->weight += share * weight;
        bin->place[0] += share * (a.x + b.x + c.x) / 3.0;
        bin->place[1] += share * (a.y + b.y + c.y) / 3.0;
        bin->place[2] += share * (a.z + b.z + c.z) / 3.0;
    }
}

/* One coordinate of the centre at a weight; where nothing is like it, the elbow. */
static CenterNode bin_node(const WeightBin *bins, size_t axis, double weight)
{
    double sum = 0.0, sum_rate = 0.0, moment = 0.0, moment_rate = 0.0;
    for (size_t k = 0; k < WEIGHT_BINS; k++) {
        if (bins[k].area > 0.0) {
            double away = (weight - bins[k].weight / bins[k].area) / likeness_width;
            double likeness = exp(-away * away);
            double likeness_rate = -2.0 * away / likeness_width * likeness;
            sum += bins[k].area * likeness;
            sum_rate += bins[k].area * likeness_rate;
            moment += bins[k].place[axis] * likeness;
            moment_rate += bins[k].place[axis] * likeness_rate;
        }
    }
    CenterNode node = {0.0, 0.0};
    if (sum > 0.0) {
        node.place = moment / sum;
        node.rate = (moment_rate - node.place * sum_rate) / sum;
    }
    return node;
}

/* `stride` from one row to the next. */
static void set_vertex_centers(const ArmMesh *mesh, float *rows, size_t stride)
{
    WeightBin bins[WEIGHT_BINS];
    CenterNode table[CENTER_STEPS + 1];
    size_t n = mesh->vertex_count;
    fill_bins(mesh, bins);
    for (size_t axis = 0; axis < 3; axis++) {
        for (size_t k = 0; k <= CENTER_STEPS; k++) {
            table[k] = bin_node(bins, axis, (double)k / (double)CENTER_STEPS);
        }
        for (size_t i = 0; i < n; i++) {
            CenterNode node = center_between(table, (double)mesh->vertex_row[VERTEX_WEIGHT][i]);
            rows[(VERTEX_CENTER_X + axis) * stride + i] = (float)node.place;
            rows[(VERTEX_CENTER_RATE_X + axis) * stride + i] = (float)node.rate;
        }
    }
}

#endif
