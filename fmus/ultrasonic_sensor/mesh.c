/* UltrasonicSensor: the triangle mesh, cut into pieces that are short enough. */
typedef struct Mesh {
    const float *vertices;  /* all x, all y, all z */
    const float *normals;   /* the same, of length 1; NULL for flat triangles */
    const int32_t *corners; /* three a triangle, counterclockwise from outside */
    size_t count;           /* of vertices */
    size_t triangles;
} Mesh;

/* Whether both ears are on the outer side of a plane; nowhere of one without an area. */
static bool is_lit(const Pass *pass, Vector point, Vector area)
{
    return dot(area, subtract(point, pass->pair->transmitter)) < 0.0 && dot(area, subtract(point, pass->pair->receiver)) < 0.0;
}

/* Before both ears, within the range, and not behind a solid plane. */
static bool is_open(const Pass *pass, Vector point)
{
    const Surroundings *around = pass->around;
    Vector there = subtract(point, pass->pair->transmitter), here = subtract(point, pass->pair->receiver);
    bool before = dot(there, pass->pair->axis) > 0.0 && dot(here, pass->pair->receiver_axis) > 0.0;
    bool hidden = around->plane && dot(subtract(point, around->plane_point), around->plane_normal) < 0.0;
    return before && !hidden && dot(there, there) < pass->farthest_square;
}

/* A piece that both ears see, if it is where they listen. */
static void add_piece(const Pass *pass, Pieces *pieces, Vector corner, Vector along, Vector across, Vector bulge)
{
    if (!is_open(pass, corner)) {
        return;
    }
    const int i = pieces->count;
    const Vector rows[] = {corner, along, across, bulge};
    double (*columns[])[BATCH] = {pieces->corner, pieces->along, pieces->across, pieces->bulge};
    for (int j = 0; j < 4; j++) {
        columns[j][0][i] = rows[j].x;
        columns[j][1][i] = rows[j].y;
        columns[j][2][i] = rows[j].z;
    }
    pieces->count = i + 1;
    if (pieces->count == BATCH) {
        hear_pieces(pass, pieces);
    }
}

/* A triangle, and the parabola through its corners that meets their normals: in the middle of a side the surface is
 * `bulge` outside, a circle's e^2 / (8 R). */
typedef struct Patch {
    Vector corner[3], normal[3];
    double bulge[3]; /* of the side from a corner to the next */
} Patch;

/* The point of the patch with these shares of its corners. */
static Vector patch_point(const Patch *patch, double first, double second, double third)
{
    double height = 4.0 * (patch->bulge[0] * first * second + patch->bulge[1] * second * third + patch->bulge[2] * third * first);
    Vector point = scale(first, add_scaled(patch->corner[0], height, patch->normal[0]));
    point = add_scaled(point, second, add_scaled(patch->corner[1], height, patch->normal[1]));
    return add_scaled(point, third, add_scaled(patch->corner[2], height, patch->normal[2]));
}

static void add_part(const Pass *pass, Pieces *pieces, Vector a, Vector b, Vector c, Vector bulge)
{
    Vector along = subtract(b, a), across = subtract(c, a);
    if (is_lit(pass, a, cross(along, across))) {
        add_piece(pass, pieces, a, along, across, bulge);
    }
}

/* How far the surface is outside the middle of one of count x count parts. */
static Vector middle_bulge(const Patch *patch, int count)
{
    double share = 1.0 / (double)count, height = (patch->bulge[0] + patch->bulge[1] + patch->bulge[2]) / 3.0;
    return scale(height / 3.0 * share * share, add(add(patch->normal[0], patch->normal[1]), patch->normal[2]));
}

/* Cut along its sides into count x count alike, every other one turned over. */
static void add_parts(const Pass *pass, Pieces *pieces, const Patch *patch, int count)
{
    const double share = 1.0 / (double)count;
    const Vector bulge = middle_bulge(patch, count);
    for (int i = 0; i < count; i++) {
        for (int j = 0; i + j < count; j++) {
            double near = (double)(count - i - j) * share, u = (double)i * share, v = (double)j * share;
            Vector a = patch_point(patch, near, u, v), b = patch_point(patch, near - share, u + share, v);
            Vector c = patch_point(patch, near - share, u, v + share);
            add_part(pass, pieces, a, b, c, bulge);
            if (i + j < count - 1) {
                Vector d = patch_point(patch, near - 2.0 * share, u + share, v + share);
                add_part(pass, pieces, b, d, c, bulge);
            }
        }
    }
}

static Vector row_of(const float *rows, size_t count, int32_t index)
{
    return vector((double)rows[index], (double)rows[count + (size_t)index], (double)rows[2 * count + (size_t)index]);
}

/* How far the surface is outside the middle of each side; returns the longest one's square. */
static double bend_patch(const Mesh *mesh, const int32_t *corner, Patch *patch)
{
    double longest = 0.0;
    for (int i = 0; i < 3 && mesh->normals; i++) {
        patch->normal[i] = row_of(mesh->normals, mesh->count, corner[i]);
    }
    for (int i = 0; i < 3; i++) {
        int next = i == 2 ? 0 : i + 1;
        Vector side = subtract(patch->corner[next], patch->corner[i]);
        patch->bulge[i] = 0.125 * dot(side, subtract(patch->normal[next], patch->normal[i]));
        longest = greater(longest, dot(side, side));
    }
    return longest;
}

static void hear_mesh(const Pass *pass, const Mesh *mesh)
{
    Pieces pieces;
    pieces.count = 0;
    const double pieces_square = 1.0 / (pass->longest_piece * pass->longest_piece);
    const Vector none = {0.0, 0.0, 0.0};
    Patch patch = {.normal = {none, none, none}};
    for (size_t t = 0; t < mesh->triangles; t++) {
        const int32_t *corner = mesh->corners + 3 * t;
        if (corner[1] == corner[2]) {
            continue; /* an unused row */
        }
        for (int i = 0; i < 3; i++) {
            patch.corner[i] = row_of(mesh->vertices, mesh->count, corner[i]);
        }
        Vector along = subtract(patch.corner[1], patch.corner[0]), across = subtract(patch.corner[2], patch.corner[0]);
        if (is_lit(pass, patch.corner[0], cross(along, across))) {
            double square = bend_patch(mesh, corner, &patch) * pieces_square;
            if (square <= 1.0) {
                add_piece(pass, &pieces, patch.corner[0], along, across, middle_bulge(&patch, 1));
            } else {
                add_parts(pass, &pieces, &patch, (int)ceil(sqrt(square)));
            }
        }
    }
    hear_pieces(pass, &pieces);
}

/* Heard by the sensor's own ears, and with `multipath` by those that have one of them mirrored at the ground. */
static void hear_surface(const UltrasonicSensor *sensor, const Surroundings *around, const Mesh *mesh, Bins *bins)
{
    double over = exp(-sensor->threshold / DECIBEL_PER_NEPER) * sensor->capsule_reflection;
    double farthest = sensor->speed_of_sound * sensor->farthest_time;
    Pass pass = {
        .find_onsets = widest_find_onsets(),
        .sensor = sensor,
        .around = around,
        .pair = &around->pair,
        .strength = over * sensor->wave_number / (2.0 * PI), /* 2 m times k / (4 pi) */
        .longest_piece = LONGEST_PIECE * 2.0 * PI / sensor->wave_number,
        .farthest_square = farthest * farthest,
        .bins = bins,
    };
    hear_mesh(&pass, mesh);
    Transceiver pairs[2];
    int count = mirrored_pairs(sensor, around, pairs);
    pass.strength *= sensor->plane_reflection;
    for (int i = 0; i < count; i++) {
        pass.pair = &pairs[i];
        hear_mesh(&pass, mesh);
    }
}
