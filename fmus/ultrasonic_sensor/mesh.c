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
    Vector there = subtract(point, pass->pair->transmitter), here = subtract(point, pass->pair->receiver);
    bool before = dot(there, pass->pair->axis) > 0.0 && dot(here, pass->pair->receiver_axis) > 0.0;
    return before && !behind_plane(pass->around, point) && dot(there, there) < pass->farthest_square;
}

INLINED void put_row(double columns[3][BATCH], int i, Vector row)
{
    columns[0][i] = row.x;
    columns[1][i] = row.y;
    columns[2][i] = row.z;
}

/* A piece that both ears see, if it is where they listen. */
INLINED void add_piece(const Pass *pass, Pieces *pieces, Vector corner, Vector along, Vector across, Vector bulge)
{
    if (!is_open(pass, corner)) {
        return;
    }
    const int i = pieces->count++;
    put_row(pieces->corner, i, corner);
    put_row(pieces->along, i, along);
    put_row(pieces->across, i, across);
    put_row(pieces->bulge, i, bulge);
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

/* Height over the flat triangle where these are the shares of the corners; of a difference of shares, minus four times
 * how far the surface is outside the middle of the line. */
static double patch_height(const Patch *patch, Vector share)
{
    return 4.0 * (patch->bulge[0] * share.x * share.y + patch->bulge[1] * share.y * share.z + patch->bulge[2] * share.z * share.x);
}

static Vector patch_normal(const Patch *patch, Vector share)
{
    Vector normal = add_scaled(scale(share.x, patch->normal[0]), share.y, patch->normal[1]);
    return add_scaled(normal, share.z, patch->normal[2]);
}

static Vector patch_point(const Patch *patch, Vector share)
{
    Vector point = add_scaled(scale(share.x, patch->corner[0]), share.y, patch->corner[1]);
    point = add_scaled(point, share.z, patch->corner[2]);
    return add_scaled(point, patch_height(patch, share), patch_normal(patch, share));
}

/* A point of the patch and its shares of the corners. */
typedef struct Place {
    Vector share, point;
} Place;

/* `far` of the way from the first corner to the third side, and there `aside` of the way to the third corner. */
static Place place_on(const Patch *patch, double far, double aside)
{
    Vector share = {1.0 - far, far * (1.0 - aside), far * aside};
    return (Place){share, patch_point(patch, share)};
}

/* The flat piece between three places, if it is lit. */
static void add_part(const Pass *pass, Pieces *pieces, const Patch *patch, Place a, Place b, Place c)
{
    Vector along = subtract(b.point, a.point), across = subtract(c.point, a.point);
    if (is_lit(pass, a.point, cross(along, across))) {
        double height = patch_height(patch, subtract(b.share, a.share)) + patch_height(patch, subtract(c.share, b.share))
            + patch_height(patch, subtract(a.share, c.share));
        add_piece(pass, pieces, a.point, along, across, scale(-height / 12.0, patch_normal(patch, a.share)));
    }
}

/* In strips between the tip and the side across, each in as many cells, so that no cracks are left. */
static void add_strips(const Pass *pass, Pieces *pieces, const Patch *patch, int strips, int cells)
{
    for (int i = 0; i < strips; i++) {
        double near = (double)i / (double)strips, far = (double)(i + 1) / (double)strips;
        Place a = place_on(patch, near, 0.0), b = place_on(patch, far, 0.0);
        for (int j = 1; j <= cells; j++) {
            double aside = (double)j / (double)cells;
            Place c = place_on(patch, far, aside), d = place_on(patch, near, aside);
            add_part(pass, pieces, patch, a, b, c);
            if (i > 0) {
                add_part(pass, pieces, patch, a, c, d);
            }
            a = d;
            b = c;
        }
    }
}

/* Into count x count alike, every other one turned over: fewer where the sides are alike. */
static void add_alike(const Pass *pass, Pieces *pieces, const Patch *patch, int count)
{
    for (int i = 0; i < count; i++) {
        double near = (double)i / (double)count, far = (double)(i + 1) / (double)count;
        Place a = place_on(patch, near, 0.0), b = place_on(patch, far, 0.0);
        for (int j = 0; j <= i; j++) {
            Place c = place_on(patch, far, (double)(j + 1) / (double)(i + 1));
            add_part(pass, pieces, patch, a, b, c);
            if (j < i) {
                Place d = place_on(patch, near, (double)(j + 1) / (double)i);
                add_part(pass, pieces, patch, a, c, d);
                a = d;
            }
            b = c;
        }
    }
}

static Vector row_of(const float *rows, size_t count, int32_t index)
{
    return vector((double)rows[index], (double)rows[count + (size_t)index], (double)rows[2 * count + (size_t)index]);
}

/* A triangle with a `side` too long, squared; its tip is across from the shortest. */
static void add_patch(const Pass *pass, Pieces *pieces, const Mesh *mesh, const int32_t *corner, const double squares[3],
                      double side)
{
    Patch patch;
    int shortest = squares[0] < squares[1] ? (squares[0] < squares[2] ? 0 : 2) : (squares[1] < squares[2] ? 1 : 2);
    for (int i = 0; i < 3; i++) {
        int32_t index = corner[(shortest + 2 + i) % 3]; /* a side has the name of the corner where it begins */
        patch.corner[i] = row_of(mesh->vertices, mesh->count, index);
        patch.normal[i] = mesh->normals ? row_of(mesh->normals, mesh->count, index) : at_rest;
    }
    for (int i = 0; i < 3; i++) {
        int next = (i + 1) % 3;
        Vector along = subtract(patch.corner[next], patch.corner[i]);
        patch.bulge[i] = 0.125 * dot(along, subtract(patch.normal[next], patch.normal[i]));
    }
    int strips = (int)ceil(sqrt(side) / pass->longest_piece);
    int cells = (int)ceil(sqrt(squares[shortest]) / pass->longest_piece);
    if (cells == strips) {
        add_alike(pass, pieces, &patch, strips);
    } else {
        add_strips(pass, pieces, &patch, strips, cells);
    }
}

/* How far the surface is outside the middle of a triangle that need not be cut. */
static Vector middle_bulge(const Mesh *mesh, const int32_t *corner, const Vector side[3])
{
    Vector n[3];
    for (int i = 0; i < 3; i++) {
        n[i] = row_of(mesh->normals, mesh->count, corner[i]);
    }
    double turn = dot(side[0], subtract(n[1], n[0])) + dot(side[1], subtract(n[2], n[1])) + dot(side[2], subtract(n[0], n[2]));
    return scale(1.0 / 72.0 * turn, add(add(n[0], n[1]), n[2])); /* a third of an eighth, by the mean normal */
}

static void hear_mesh(const Pass *pass, const Mesh *mesh)
{
    Pieces pieces;
    pieces.count = 0;
    const double most = pass->longest_piece * pass->longest_piece;
    for (size_t t = 0; t < mesh->triangles; t++) {
        const int32_t *corner = mesh->corners + 3 * t;
        if (corner[1] == corner[2]) {
            continue; /* an unused row */
        }
        Vector a = row_of(mesh->vertices, mesh->count, corner[0]), b = row_of(mesh->vertices, mesh->count, corner[1]);
        Vector c = row_of(mesh->vertices, mesh->count, corner[2]);
        Vector side[] = {subtract(b, a), subtract(c, b), subtract(a, c)}, across = subtract(c, a);
        if (!is_lit(pass, a, cross(side[0], across))) {
            continue;
        }
        double squares[] = {dot(side[0], side[0]), dot(side[1], side[1]), dot(side[2], side[2])};
        /* half a square counts by its legs */
        double longest = greater(squares[0], greater(squares[1], squares[2]));
        double shorter = greater(lesser(squares[0], squares[1]), lesser(greater(squares[0], squares[1]), squares[2]));
        double square = greater(shorter, 0.5 * longest);
        if (square <= most) {
            add_piece(pass, &pieces, a, side[0], across, mesh->normals ? middle_bulge(mesh, corner, side) : at_rest);
        } else {
            add_patch(pass, &pieces, mesh, corner, squares, square);
        }
    }
    hear_pieces(pass, &pieces);
}

/* Heard by the sensor's own ears, and with `multipath` by those that have one of them mirrored at the ground. */
static void hear_surface(const UltrasonicSensor *sensor, const Surroundings *around, const Mesh *mesh, Bins *bins)
{
    double over = sensor->capsule_reflection / sensor->threshold_amplitude;
    double farthest = sensor->speed_of_sound * sensor->farthest_time;
    Pass pass = {
        .instruction_set = widest_instruction_set(),
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
