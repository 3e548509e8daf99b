/* ArmSkin: a mesh of the user's, mesh.bin among the FMU's resources. The README has the format; here
 * every size, range and sum of it is checked before anything is computed from it.
 */
#include "equations.h"
#include "centers.c"
#include "vertices.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { MESH_FORMAT = 1, MOST_JOINTS = 256, INFLUENCES = 4, GIVEN_ROWS = VERTEX_CENTER_X - 1 };

#define MOST_VERTICES 4194304u
#define FARTHEST 100.0f /* m */
#define WEIGHT_TOLERANCE 1e-3f
#define NORMAL_TOLERANCE 1e-2f

typedef struct MeshHeader {
    char magic[8];
    uint32_t format, vertex_count, triangle_count, joint_count;
    double upper_arm_length, forearm_length, radius, blend_half_width;
    char reserved[8];
    uint8_t forearm[MOST_JOINTS]; /* of each joint: 0 follows the upper arm, 1 the forearm */
} MeshHeader;

/* From one row of vertices to the next: rows begin where the widest vectors do. */
enum { ROW_BYTES = 64, ROW_FLOATS = ROW_BYTES / sizeof(float) };

static size_t row_stride(size_t vertex_count)
{
    return (vertex_count + ROW_FLOATS - 1) / ROW_FLOATS * ROW_FLOATS;
}

static uint64_t mesh_file_size(const MeshHeader *header)
{
    uint64_t a_vertex = GIVEN_ROWS * sizeof(float) + INFLUENCES * (sizeof(float) + sizeof(uint8_t));
    return sizeof *header + header->vertex_count * a_vertex + header->triangle_count * 3ULL * sizeof(int32_t);
}

static Status bad_mesh(Log *log, const char *reason)
{
    return report(log, STATUS_ERROR, "the mesh among the resources is refused: %s", reason);
}

static bool length_is_possible(double length, double most)
{
    return length > 0.0 && length <= most;
}

static Status check_mesh_header(const MeshHeader *header, uint64_t size, Log *log)
{
    if (size < sizeof *header || memcmp(header->magic, "UlnaSkin", sizeof header->magic) != 0) {
        return bad_mesh(log, "it does not begin with the header of a skin");
    }
    if (header->format != MESH_FORMAT) {
        return bad_mesh(log, "its format is another than 1, or its bytes are in another order");
    }
    if (header->vertex_count < 32 || header->vertex_count > MOST_VERTICES) {
        return report(log, STATUS_ERROR, "the mesh among the resources has %" PRIu32 " vertices; allowed range: 32 to %u",
                      header->vertex_count, MOST_VERTICES);
    }
    if (header->triangle_count < 1 || header->triangle_count > 2 * header->vertex_count) {
        return report(log, STATUS_ERROR,
                      "the mesh among the resources has %" PRIu32 " triangles; allowed range: 1 to twice its %" PRIu32
                      " vertices", header->triangle_count, header->vertex_count);
    }
    if (header->joint_count < 1 || header->joint_count > MOST_JOINTS) {
        return bad_mesh(log, "it has no joints, or more than 256");
    }
    for (size_t j = 0; j < MOST_JOINTS; j++) {
        if (header->forearm[j] > 1) {
            return bad_mesh(log, "a joint follows neither the upper arm (0) nor the forearm (1)");
        }
    }
    if (!length_is_possible(header->upper_arm_length, 100.0) || !length_is_possible(header->forearm_length, 100.0) ||
        !length_is_possible(header->radius, 10.0) || !length_is_possible(header->blend_half_width, 100.0)) {
        return bad_mesh(log, "a length of its arm is not above 0, or above what the parameter allows");
    }
    if (size != mesh_file_size(header)) {
        return report(log, STATUS_ERROR, "the mesh among the resources has %" PRIu64 " bytes; its header says %" PRIu64, size,
                      mesh_file_size(header));
    }
    return STATUS_OK;
}

/* Opens the file and checks its header; *file is NULL where there is none. */
static Status open_mesh(const char *resources, FILE **file, MeshHeader *header, Log *log)
{
    char path[4096];
    *file = NULL;
    int length = snprintf(path, sizeof path, "%smesh.bin", resources);
    if (!*resources || length < 0) {
        return STATUS_OK;
    }
    if ((size_t)length >= sizeof path) {
        return report(log, STATUS_ERROR, "the path of the resources is longer than %zu characters", sizeof path - 10);
    }
    *file = fopen(path, "rb");
    if (!*file) {
        return STATUS_OK;
    }
    memset(header, 0, sizeof *header);
    size_t read = fread(header, 1, sizeof *header, *file);
    long end = fseek(*file, 0, SEEK_END) == 0 ? ftell(*file) : -1;
    Status status = end < 0 || read > (size_t)end ? bad_mesh(log, "it cannot be read")
                                                  : check_mesh_header(header, (uint64_t)end, log);
    if (status == STATUS_OK && fseek(*file, (long)sizeof *header, SEEK_SET) != 0) {
        status = bad_mesh(log, "it cannot be read");
    }
    if (status != STATUS_OK) {
        fclose(*file);
        *file = NULL;
    }
    return status;
}

/* The parameters at the start are those that the mesh was made for. */
static Status arm_skin_start(ArmSkin *skin, const char *resources, Log *log)
{
    FILE *file;
    MeshHeader header;
    Status status = open_mesh(resources, &file, &header, log);
    if (file) {
        fclose(file);
        skin->imported = true;
        skin->vertex_count = header.vertex_count;
        skin->triangle_count = header.triangle_count;
        skin->upper_arm_length = header.upper_arm_length;
        skin->forearm_length = header.forearm_length;
        skin->radius = header.radius;
        skin->blend_half_width = header.blend_half_width;
        skin->forearm_position = vector(header.upper_arm_length, 0.0, 0.0);
    }
    return status;
}

static Status check_rows(const ArmMesh *mesh, Log *log)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const float *const *row = mesh->vertex_row;
        float normal = 0.0f;
        for (size_t axis = 0; axis < 3; axis++) {
            if (!(fabsf(row[VERTEX_X + axis][i]) <= FARTHEST)) {
                return report(log, STATUS_ERROR, "the mesh among the resources: vertex %zu is not within %g m of the elbow", i,
                              (double)FARTHEST);
            }
            if (!isfinite(row[VERTEX_LEVEL_X + axis][i])) {
                return report(log, STATUS_ERROR, "the mesh among the resources: gradient %zu is not finite", i);
            }
            normal += row[VERTEX_NORMAL_X + axis][i] * row[VERTEX_NORMAL_X + axis][i];
        }
        if (!(fabsf(normal - 1.0f) <= NORMAL_TOLERANCE)) {
            return report(log, STATUS_ERROR, "the mesh among the resources: normal %zu has no length of 1", i);
        }
    }
    return STATUS_OK;
}

/* The forearm's share in each vertex, from its influences: weights, then numbers of joints. */
static Status sum_weights(const MeshHeader *header, bool rigid, const float *weights, const uint8_t *joints, float *share,
                          Log *log)
{
    size_t n = header->vertex_count;
    for (size_t i = 0; i < n; i++) {
        float sum = 0.0f, forearm = 0.0f;
        for (size_t k = 0; k < INFLUENCES; k++) {
            float weight = weights[k * n + i];
            uint8_t joint = joints[k * n + i];
            if (!(weight >= 0.0f && weight <= 1.0f) || joint >= header->joint_count) {
                return report(log, STATUS_ERROR,
                              "the mesh among the resources: vertex %zu has weight %g of joint %u; allowed range: 0 to 1, and "
                              "a joint below %u", i, (double)weight, (unsigned)joint, (unsigned)header->joint_count);
            }
            sum += weight;
            forearm += header->forearm[joint] ? weight : 0.0f;
        }
        if (!(fabsf(sum - 1.0f) <= WEIGHT_TOLERANCE)) {
            return report(log, STATUS_ERROR, "the mesh among the resources: the weights of vertex %zu sum to %g, not to 1", i,
                          (double)sum);
        }
        forearm /= sum;
        share[i] = rigid ? (float)(forearm >= 0.5f) : forearm;
    }
    return STATUS_OK;
}

static Status check_triangles(const ArmMesh *mesh, Log *log)
{
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const int32_t *corner = mesh->triangle + 3 * t;
        for (size_t k = 0; k < 3; k++) {
            if (corner[k] < 0 || (size_t)corner[k] >= mesh->vertex_count || corner[k] == corner[(k + 1) % 3]) {
                return report(log, STATUS_ERROR,
                              "the mesh among the resources: triangle %zu is of vertices %d, %d, %d; allowed range: three of 0 "
                              "to %zu", t, (int)corner[0], (int)corner[1], (int)corner[2], mesh->vertex_count - 1);
            }
        }
    }
    return STATUS_OK;
}

/* Half of the flux of (0, y, z) through the triangles that bend: the volume between the sections at
 * both ends of the zone. */
static double bending_volume(const ArmMesh *mesh)
{
    double sum = 0.0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (triangle_bends(mesh, t)) {
            MeshCorner a = mesh_corner(mesh, t, 0), b = mesh_corner(mesh, t, 1), c = mesh_corner(mesh, t, 2);
            double area_y = (b.z - a.z) * (c.x - a.x) - (b.x - a.x) * (c.z - a.z);
            double area_z = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            sum += (a.y + b.y + c.y) * area_y + (a.z + b.z + c.z) * area_z;
        }
    }
    return sum / 12.0;
}

/* Normals at length 1, and gradients turned into lines of equal weight. */
static void set_levels(size_t n, float *rows)
{
    size_t stride = row_stride(n);
    float *normal = rows + VERTEX_NORMAL_X * stride, *level = rows + VERTEX_LEVEL_X * stride;
    for (size_t i = 0; i < n; i++) {
        Vector along = vector((double)normal[i], (double)normal[stride + i], (double)normal[2 * stride + i]);
        Vector gradient = vector((double)level[i], (double)level[stride + i], (double)level[2 * stride + i]);
        along = scale(1.0 / norm(along), along);
        Vector across = level_line(gradient, along);
        normal[i] = (float)along.x;
        normal[stride + i] = (float)along.y;
        normal[2 * stride + i] = (float)along.z;
        level[i] = (float)across.x;
        level[stride + i] = (float)across.y;
        level[2 * stride + i] = (float)across.z;
    }
}

static Holder holder_of(const ArmMesh *mesh, size_t i)
{
    float weight = mesh->vertex_row[VERTEX_WEIGHT][i];
    bool level = mesh->vertex_row[VERTEX_LEVEL_X][i] == 0.0f && mesh->vertex_row[VERTEX_LEVEL_X + 1][i] == 0.0f &&
                 mesh->vertex_row[VERTEX_LEVEL_X + 2][i] == 0.0f;
    return level && weight == 0.0f ? FOLLOWS_UPPER_ARM : level && weight == 1.0f ? FOLLOWS_FOREARM : FOLLOWS_BOTH;
}

/* Neighbours in number that follow the same, LEAST_RUN at a time. */
static size_t set_runs(const ArmMesh *mesh, VertexRun *run)
{
    size_t count = 0;
    for (size_t begin = 0; begin < mesh->vertex_count; begin += LEAST_RUN) {
        size_t end = begin + LEAST_RUN < mesh->vertex_count ? begin + LEAST_RUN : mesh->vertex_count;
        Holder holder = holder_of(mesh, begin);
        for (size_t i = begin + 1; i < end; i++) {
            holder = holder_of(mesh, i) == holder ? holder : FOLLOWS_BOTH;
        }
        if (count && run[count - 1].holder == holder) {
            run[count - 1].end = end;
        } else {
            VertexRun next = {begin, end, holder};
            run[count++] = next;
        }
    }
    return count;
}

static bool read_rows(FILE *file, size_t n, size_t count, float *rows)
{
    bool read = true;
    for (size_t row = 0; row < count && read; row++) {
        read = fread(rows + row * row_stride(n), sizeof(float), n, file) == n;
    }
    return read;
}

static Status read_mesh(FILE *file, const MeshHeader *header, bool rigid, ArmMesh *mesh, float *rows, int32_t *triangle,
                        Log *log)
{
    size_t n = header->vertex_count, stride = row_stride(n);
    float *share = rows + VERTEX_WEIGHT * stride;
    /* the rows of centres are free until the weights are known */
    float *weights = rows + VERTEX_CENTER_X * stride;
    uint8_t *joints = (uint8_t *)(rows + (VERTEX_CENTER_X + INFLUENCES) * stride);
    bool read = read_rows(file, n, VERTEX_WEIGHT, rows) && read_rows(file, n, 3, rows + VERTEX_LEVEL_X * stride) &&
                fread(weights, sizeof(float), INFLUENCES * n, file) == INFLUENCES * n &&
                fread(joints, 1, INFLUENCES * n, file) == INFLUENCES * n &&
                fread(triangle, sizeof(int32_t), 3 * mesh->triangle_count, file) == 3 * mesh->triangle_count;
    Status status = read ? check_rows(mesh, log) : bad_mesh(log, "it cannot be read");
    status = status == STATUS_OK ? sum_weights(header, rigid, weights, joints, share, log) : status;
    status = status == STATUS_OK ? check_triangles(mesh, log) : status;
    if (status == STATUS_OK && rigid) {
        memset(rows + VERTEX_LEVEL_X * stride, 0, 3 * stride * sizeof(float));
    }
    if (status == STATUS_OK) {
        set_levels(n, rows);
    }
    return status;
}

static size_t most_runs(size_t vertex_count)
{
    return vertex_count / LEAST_RUN + 1;
}

/* The mesh, its runs, its rows and its triangles lie in the workspace one after the other. */
static Status prepare_imported(const ArmSkin *skin, const char *resources, ArmMesh *mesh, Log *log)
{
    FILE *file;
    MeshHeader header;
    Status status = open_mesh(resources, &file, &header, log);
    if (status == STATUS_OK && !file) {
        return bad_mesh(log, "it is no longer there");
    }
    if (status != STATUS_OK) {
        return status;
    }
    bool same = header.vertex_count == skin->vertex_count && header.triangle_count == skin->triangle_count &&
                header.upper_arm_length == skin->upper_arm_length && header.forearm_length == skin->forearm_length;
    if (!same) {
        fclose(file);
        return report(log, STATUS_ERROR,
                      "vertex_count, upper_arm_length and forearm_length are those of the mesh among the resources; allowed "
                      "range: %" PRIu32 ", %.17g m and %.17g m", header.vertex_count, header.upper_arm_length,
                      header.forearm_length);
    }
    memset(mesh, 0, sizeof *mesh);
    mesh->vertex_count = header.vertex_count;
    mesh->triangle_count = header.triangle_count;
    VertexRun *run = (VertexRun *)(mesh + 1);
    size_t before = (uintptr_t)(run + most_runs(mesh->vertex_count)) % ROW_BYTES;
    float *rows = (float *)((char *)(run + most_runs(mesh->vertex_count)) + (ROW_BYTES - before) % ROW_BYTES);
    size_t stride = row_stride(mesh->vertex_count);
    int32_t *triangle = (int32_t *)(rows + VERTEX_ROWS * stride);
    mesh->triangle = triangle;
    for (size_t row = 0; row < VERTEX_ROWS; row++) {
        mesh->vertex_row[row] = rows + row * stride;
    }
    status = read_mesh(file, &header, skin->method == ARM_SKIN_METHOD_RIGID, mesh, rows, triangle, log);
    fclose(file);
    if (status == STATUS_OK) {
        mesh->run = run;
        mesh->run_count = set_runs(mesh, run);
        set_vertex_centers(mesh, rows, stride);
        mesh->zone_volume = bending_volume(mesh);
    }
    return status;
}

static size_t imported_size(const ArmSkin *skin)
{
    return sizeof(ArmMesh) + most_runs((size_t)skin->vertex_count) * sizeof(VertexRun) + ROW_BYTES +
           row_stride((size_t)skin->vertex_count) * VERTEX_ROWS * sizeof(float) +
           (size_t)skin->triangle_count * 3 * sizeof(int32_t);
}

static void fill_imported_triangles(const ArmMesh *mesh, int32_t *corner)
{
    memset(corner, 0, 6 * mesh->vertex_count * sizeof *corner);
    memcpy(corner, mesh->triangle, 3 * mesh->triangle_count * sizeof *corner);
}
