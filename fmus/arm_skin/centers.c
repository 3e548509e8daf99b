/* ArmSkin: optimised centres of rotation (Le and Hodgins 2016), made with the mesh.
 *
 * The centre of a vertex is the mean of the skin's points, each by its area and by how alike its
 * weights are to the vertex's. With two bones and weights w, v of the forearm (their equation 1)
 *
 *   s(w, v) = 2 w (1 - w) v (1 - v) exp(-((w - v) / sigma)^2)
 *
 * so the centre depends on w alone, and w (1 - w) divides out: it has limits at 0 and 1 as well.
 */
#include "mesh.h"

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

/* `rigid` has no weights in between, and no use for centres. */
static void set_centers(const ArmMesh *mesh, ArmRing *rings)
{
    CenterNode table[CENTER_STEPS + 1];
    bool blended = rings[mesh->elbow].weight < 1.0;
    for (size_t k = 0; k <= CENTER_STEPS; k++) {
        CenterNode none = {0.0, 0.0};
        table[k] = blended ? center_node(mesh, (double)k / CENTER_STEPS) : none;
    }
    for (size_t i = 0; i < mesh->ring_count; i++) {
        double place = rings[i].weight * CENTER_STEPS;
        size_t k = place < CENTER_STEPS ? (size_t)place : CENTER_STEPS - 1;
        CenterNode node = between_nodes(table[k], table[k + 1], 1.0 / CENTER_STEPS, place - (double)k);
        rings[i].center = node.place;
        rings[i].center_rate = node.rate;
    }
}
