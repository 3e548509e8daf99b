/* UltrasonicSensor: whether there is a mesh, and what a mesh may be. */

/* A triangle has three corners; rows that are left have one. */
static bool is_triangle(const int32_t *corner)
{
    return corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0];
}

static bool mesh_of(const UltrasonicSensor *sensor, Mesh *mesh)
{
    const float *normals = ultrasonic_sensor_surface_normals(sensor);
    size_t count = (size_t)sensor->surface_vertex_count;
    bool flat = normals[0] == 0.0f && normals[count] == 0.0f && normals[2 * count] == 0.0f;
    mesh->vertices = ultrasonic_sensor_surface_vertices(sensor);
    mesh->normals = flat ? NULL : normals;
    mesh->corners = ultrasonic_sensor_surface_triangles(sensor);
    mesh->count = count;
    mesh->triangles = 2 * count;
    for (size_t t = 0; t < mesh->triangles; t++) {
        if (is_triangle(mesh->corners + 3 * t)) {
            return true;
        }
    }
    return false;
}

/* One sign tells of all indices whether one is below 0 or above the last vertex: this runs after every change. */
static Status check_triangles(const UltrasonicSensor *sensor, Log *log)
{
    const int32_t *vertices = ultrasonic_sensor_surface_triangles(sensor);
    size_t count = 6 * (size_t)sensor->surface_vertex_count;
    uint32_t last = (uint32_t)sensor->surface_vertex_count - 1, outside = 0;
    for (size_t k = 0; k < count; k++) {
        outside |= (last - (uint32_t)vertices[k]) | (uint32_t)vertices[k];
    }
    for (size_t k = 0; outside >> 31 && k < count; k++) {
        if (vertices[k] < 0 || (uint32_t)vertices[k] > last) {
            return report(log, STATUS_ERROR, "surface_triangles[%zu] = %" PRId32 "; allowed range: 0 to "
                          "surface_vertex_count - 1 (%" PRIu32 ")", k + 1, vertices[k], last);
        }
    }
    return STATUS_OK;
}

#define UNIT_LENGTH_SLACK 0.01 /* of a normal: the surface is off by that share of its bulge */

static Status check_normals(const Mesh *mesh, Log *log)
{
    const float *x = mesh->normals, *y = x + mesh->count, *z = y + mesh->count;
    for (size_t i = 0; i < mesh->count; i++) {
        double length = sqrt((double)x[i] * (double)x[i] + (double)y[i] * (double)y[i] + (double)z[i] * (double)z[i]);
        if (!(fabs(length - 1.0) <= UNIT_LENGTH_SLACK)) {
            return report(log, STATUS_ERROR,
                          "surface_normals has a normal of length %g, of vertex %zu; allowed range: %g to %g, or all zero "
                          "for flat triangles", length, i, 1.0 - UNIT_LENGTH_SLACK, 1.0 + UNIT_LENGTH_SLACK);
        }
    }
    return STATUS_OK;
}

#define LONGEST_EDGE 1.0 /* m; such a triangle is cut into some 100 000 pieces */

enum { LANES = 8 };

/* Least and greatest coordinate, several at a time. */
static double extent_of(const float *row, size_t count)
{
    float low[LANES], high[LANES];
    for (int k = 0; k < LANES; k++) {
        low[k] = high[k] = row[0];
    }
    for (size_t i = 0; i + LANES <= count; i += LANES) {
        for (int k = 0; k < LANES; k++) {
            float value = row[i + (size_t)k];
            low[k] = value < low[k] ? value : low[k];
            high[k] = value > high[k] ? value : high[k];
        }
    }
    for (size_t i = count / LANES * LANES; i < count; i++) {
        low[0] = row[i] < low[0] ? row[i] : low[0];
        high[0] = row[i] > high[0] ? row[i] : high[0];
    }
    for (int k = 1; k < LANES; k++) {
        low[0] = low[k] < low[0] ? low[k] : low[0];
        high[0] = high[k] > high[0] ? high[k] : high[0];
    }
    return (double)high[0] - (double)low[0];
}

/* Edges are looked at only where the mesh is large enough to have such a one. */
static Status check_edges(const Mesh *mesh, Log *log)
{
    Vector size = {extent_of(mesh->vertices, mesh->count), extent_of(mesh->vertices + mesh->count, mesh->count),
                   extent_of(mesh->vertices + 2 * mesh->count, mesh->count)};
    for (size_t t = 0; dot(size, size) > LONGEST_EDGE * LONGEST_EDGE && t < mesh->triangles; t++) {
        const int32_t *corner = mesh->corners + 3 * t;
        for (int i = 0; i < 3; i++) {
            Vector start = row_of(mesh->vertices, mesh->count, corner[i]);
            double length = norm(subtract(row_of(mesh->vertices, mesh->count, corner[(i + 1) % 3]), start));
            if (length > LONGEST_EDGE) {
                return report(log, STATUS_ERROR,
                              "surface_triangles has an edge %g m long, of triangle %zu; allowed range: up to %g m", length,
                              t, LONGEST_EDGE);
            }
        }
    }
    return STATUS_OK;
}

static Status check_surface(const UltrasonicSensor *sensor, Log *log)
{
    Mesh mesh;
    Status status = check_triangles(sensor, log);
    if (status != STATUS_OK || sensor->fidelity < ULTRASONIC_SENSOR_FIDELITY_SURFACE) {
        return status;
    }
    if (!mesh_of(sensor, &mesh)) {
        return sensor->fidelity == ULTRASONIC_SENSOR_FIDELITY_AUTOMATIC
            ? STATUS_OK
            : report(log, STATUS_ERROR, "fidelity = surface needs a mesh, but surface_triangles has no triangle; FMI 2.0 "
                     "cannot give one: take automatic or specular there");
    }
    status = mesh.normals ? check_normals(&mesh, log) : STATUS_OK;
    return status == STATUS_OK ? check_edges(&mesh, log) : status;
}
