/* ArmSkin: builds the mesh at rest, ring by ring from the shoulder to the hand.
 *
 * Half of the rings share the blend zone in equal steps, so that a ring lies on the elbow and on
 * both ends of the zone; a tenth makes each round end, in equal angles; the straight parts have
 * the rest, by their lengths. The last ring of a round end is small and closed by a flat polygon.
 */
#include "equations.h"
#include "centers.c"
#include "imported.c"
#include "profile.c"

/* Steps between rings: shoulder's end, straight, half of the zone (twice), straight, hand's end. */
typedef struct RingPlan {
    size_t end, upper_arm, half_zone, forearm;
} RingPlan;

static double pi_half(void)
{
    return acos(0.0);
}

static size_t arm_skin_ring_count(const ArmSkin *skin)
{
    return (size_t)(skin->vertex_count / RING_VERTICES);
}

static RingPlan arm_skin_plan(const ArmSkin *skin)
{
    size_t rings = arm_skin_ring_count(skin);
    RingPlan plan = {.end = rings / 10, .half_zone = rings / 4};
    size_t straight = rings - 1 - 2 * plan.end - 2 * plan.half_zone;
    double upper_arm = skin->upper_arm_length - skin->radius - skin->blend_half_width;
    double forearm = skin->forearm_length - hand_radius(skin) - skin->blend_half_width;
    plan.upper_arm = 1 + (size_t)((double)(straight - 2) * upper_arm / (upper_arm + forearm) + 0.5);
    plan.forearm = straight - plan.upper_arm;
    return plan;
}

/* Smoothstep, w = 3 s^2 - 2 s^3 with s from 0 to 1 over the zone; a jump for `rigid`. */
static void set_weight(const ArmSkin *skin, ArmRing *ring)
{
    double width = 2.0 * skin->blend_half_width;
    double s = fmin(fmax(ring->x / width + 0.5, 0.0), 1.0);
    bool jump = skin->method == ARM_SKIN_METHOD_RIGID;
    ring->weight = jump ? (double)(ring->x >= 0.0) : s * s * (3.0 - 2.0 * s);
    ring->weight_slope = jump ? 0.0 : 6.0 * s * (1.0 - s) / width;
    double straight = skin->forearm_length - skin->radius - skin->blend_half_width;
    ring->spread = fmin(fmax((ring->x - skin->blend_half_width) / straight, 0.0), 1.0);
}

/* A ring on a straight part, `step` of `steps` from one place to another. */
static ArmRing straight_ring(const ArmSkin *skin, double from, double to, size_t step, size_t steps)
{
    double share = (double)step / (double)steps;
    ArmRing ring = {.x = from * (1.0 - share) + to * share};
    Thickness thickness = thickness_at(skin, ring.x);
    double steepness = hypot(1.0, thickness.slope);
    ring.radius = thickness.radius;
    ring.normal_x = -thickness.slope / steepness;
    ring.normal_radial = 1.0 / steepness;
    return ring;
}

/* A ring on the round end about `center`, `step` of `steps` and a half from its pole, which lies
 * on the side of `sign`. */
static ArmRing end_ring(double radius, double center, double sign, size_t step, size_t steps)
{
    double angle = pi_half() * ((double)step + 0.5) / ((double)steps + 0.5);
    ArmRing ring = {.normal_x = sign * cos(angle), .normal_radial = sin(angle)};
    ring.x = center + radius * ring.normal_x;
    ring.radius = radius * ring.normal_radial;
    return ring;
}

static void place_rings(const ArmSkin *skin, RingPlan plan, ArmRing *ring)
{
    double shoulder = skin->radius - skin->upper_arm_length;
    double end_radius = hand_radius(skin);
    double hand = skin->forearm_length - end_radius;
    double h = skin->blend_half_width;
    for (size_t i = 0; i < plan.end; i++) {
        *ring++ = end_ring(skin->radius, shoulder, -1.0, i, plan.end);
    }
    for (size_t i = 0; i < plan.upper_arm; i++) {
        *ring++ = straight_ring(skin, shoulder, -h, i, plan.upper_arm);
    }
    for (size_t i = 0; i < 2 * plan.half_zone; i++) {
        *ring++ = straight_ring(skin, -h, h, i, 2 * plan.half_zone);
    }
    for (size_t i = 0; i <= plan.forearm; i++) {
        *ring++ = straight_ring(skin, h, hand, i, plan.forearm);
    }
    for (size_t i = plan.end; i > 0; i--) {
        *ring++ = end_ring(end_radius, hand, 1.0, i - 1, plan.end);
    }
}

static void fill_rows(const ArmMesh *mesh, float *rows)
{
    size_t n = mesh->ring_count;
    for (size_t i = 0; i < n; i++) {
        const ArmRing *ring = &mesh->rings[i];
        rows[RING_X * n + i] = (float)ring->x;
        rows[RING_RADIUS * n + i] = (float)ring->radius;
        rows[RING_NORMAL_X * n + i] = (float)ring->normal_x;
        rows[RING_NORMAL_RADIAL * n + i] = (float)ring->normal_radial;
        rows[RING_WEIGHT * n + i] = (float)ring->weight;
        rows[RING_SLOPE * n + i] = (float)ring->weight_slope;
        rows[RING_CENTER * n + i] = (float)ring->center;
        rows[RING_CENTER_RATE * n + i] = (float)ring->center_rate;
        rows[RING_SPREAD * n + i] = (float)ring->spread;
    }
}

/* The Legendre polynomial of degree ZONE_NODES at z by its recurrence, and its derivative. */
static double legendre(double z, double *slope)
{
    double value = z, before = 1.0;
    for (int k = 2; k <= ZONE_NODES; k++) {
        double next = ((2 * k - 1) * z * value - (k - 1) * before) / k;
        before = value;
        value = next;
    }
    *slope = (double)ZONE_NODES * (before - z * value) / (1.0 - z * z);
    return value;
}

/* Where integrals over the blend zone are taken: Gauss and Legendre's rule, its places by Newton. */
static void place_nodes(const ArmSkin *skin, ZoneNode *node)
{
    double volume = 0.0;
    for (size_t i = 0; i < ZONE_NODES; i++) {
        double slope = 0.0;
        double z = cos(2.0 * pi_half() * ((double)i + 0.75) / ((double)ZONE_NODES + 0.5));
        for (int k = 0; k < 5; k++) {
            double value = legendre(z, &slope);
            z -= value / slope;
        }
        double s = 0.5 + 0.5 * z;
        node[i].weight = s * s * (3.0 - 2.0 * s);
        node[i].length = 1.0 / ((1.0 - z * z) * slope * slope);
        node[i].weight_step = 6.0 * s * (1.0 - s) * node[i].length;
        double radius = thickness_at(skin, skin->blend_half_width * z).radius;
        node[i].area = radius * radius;
        volume += node[i].area * node[i].length;
    }
    for (size_t i = 0; i < ZONE_NODES; i++) {
        node[i].area /= volume;
    }
}

static size_t arm_skin_workspace_size(const ArmSkin *skin)
{
    if (skin->imported) {
        return imported_size(skin);
    }
    return sizeof(ArmMesh) + arm_skin_ring_count(skin) * (sizeof(ArmRing) + RING_ROWS * sizeof(float));
}

/* The mesh, its rings and its rows lie in the workspace one after the other. */
static Status arm_skin_prepare(const ArmSkin *skin, const char *resources, void *workspace, Log *log)
{
    ArmMesh *mesh = workspace;
    if (skin->imported) {
        Status status = prepare_imported(skin, resources, mesh, log);
        place_nodes(skin, mesh->node);
        return status;
    }
    RingPlan plan = arm_skin_plan(skin);
    mesh->vertex_count = (size_t)skin->vertex_count;
    mesh->ring_count = arm_skin_ring_count(skin);
    mesh->zone_start = plan.end + plan.upper_arm;
    mesh->elbow = mesh->zone_start + plan.half_zone;
    mesh->zone_end = mesh->elbow + plan.half_zone;

    ArmRing *rings = (ArmRing *)(mesh + 1);
    float *rows = (float *)(rings + mesh->ring_count);
    mesh->rings = rings;
    for (size_t row = 0; row < RING_ROWS; row++) {
        mesh->ring_row[row] = rows + row * mesh->ring_count;
    }
    place_rings(skin, plan, rings);
    for (size_t i = 0; i < mesh->ring_count; i++) {
        set_weight(skin, &rings[i]);
    }
    set_centers(mesh, rings);
    place_nodes(skin, mesh->node);

    double spoke = 4.0 * pi_half() / (double)RING_VERTICES;
    for (size_t k = 0; k <= RING_VERTICES; k++) {
        double angle = spoke * (double)(k % RING_VERTICES);
        mesh->cosine[k] = cos(angle);
        mesh->sine[k] = sin(angle);
        if (k < RING_VERTICES) {
            mesh->spoke_y[k] = (float)mesh->cosine[k];
            mesh->spoke_z[k] = (float)mesh->sine[k];
        }
    }
    mesh->unit_ring_area = 0.5 * (double)RING_VERTICES * sin(spoke);
    mesh->zone_volume = 0.0;
    for (size_t i = mesh->zone_start; i < mesh->zone_end; i++) {
        double a = rings[i].radius;
        double b = rings[i + 1].radius;
        mesh->zone_volume += mesh->unit_ring_area * (a * a + a * b + b * b) / 3.0 * (rings[i + 1].x - rings[i].x);
    }
    fill_rows(mesh, rows);
    mesh->triangle_count = 0;
    mesh->run_count = 0;
    return STATUS_OK;
}

static int32_t *put_triangle(int32_t *corner, size_t a, size_t b, size_t c)
{
    corner[0] = (int32_t)a;
    corner[1] = (int32_t)b;
    corner[2] = (int32_t)c;
    return corner + 3;
}

/* The bands between rings as `measure_band` splits them, then the flat ends, then what is unused. */
static void fill_triangles(const ArmMesh *mesh, int32_t *corner)
{
    if (mesh->triangle_count) {
        fill_imported_triangles(mesh, corner);
        return;
    }
    size_t last = mesh->vertex_count - RING_VERTICES;
    for (size_t before = 0; before < last; before += RING_VERTICES) {
        size_t after = before + RING_VERTICES;
        for (size_t k = 0; k < RING_VERTICES; k++) {
            Diagonal split = band_diagonal(k);
            size_t next = (k + 1) % RING_VERTICES;
            corner = put_triangle(corner, before + k, before + next, after + split.after % RING_VERTICES);
            corner = put_triangle(corner, after + k, before + split.before % RING_VERTICES, after + next);
        }
    }
    for (size_t k = 1; k + 1 < RING_VERTICES; k++) {
        corner = put_triangle(corner, 0, k + 1, k);
        corner = put_triangle(corner, last, last + k, last + k + 1);
    }
    for (size_t i = 0; i < UNUSED_TRIANGLES; i++) {
        corner = put_triangle(corner, 0, 0, 0);
    }
}

static void fill_weights(const ArmMesh *mesh, float *weight)
{
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        weight[v] = mesh->triangle_count ? mesh->vertex_row[VERTEX_WEIGHT][v] : mesh->ring_row[RING_WEIGHT][v / RING_VERTICES];
    }
}
