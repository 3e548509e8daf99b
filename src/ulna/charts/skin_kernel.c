/* The deformation of the skin by itself, without the FMI around it, in each of the instruction sets that the FMU's binary
 * carries; and loops of the same traffic without arithmetic: the same sources, the same compiler. */
#define _POSIX_C_SOURCE 199309L
#include <stdlib.h>
#include <time.h>

#include "fmu.c"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

typedef struct Kernel {
    ArmSkin skin;
    ArmMesh *mesh;
    float *source; /* rows that the loops without arithmetic read */
} Kernel;

enum { READ_ROWS = 10 };

void kernel_close(Kernel *kernel)
{
    if (kernel) {
        free(kernel->mesh);
        free(kernel->source);
        free(kernel);
    }
}

/* A skin in a pose, with a mesh of its own where there are no resources; NULL if it is refused. `bones`: position and
 * orientation of the upper arm, then of the forearm. */
Kernel *kernel_open(const char *resources, long method, long vertex_count, double twist_share, const double *bones)
{
    Log silent = {0};
    Kernel *kernel = calloc(1, sizeof *kernel);
    if (!kernel) {
        return NULL;
    }
    ArmSkin *skin = &kernel->skin;
    *skin = start_values;
    skin->vertex_count = (uint64_t)vertex_count;
    Status status = arm_skin_start(skin, resources, &silent);
    skin->method = method;
    skin->twist_share = twist_share;
    skin->upper_arm_position = vector(bones[0], bones[1], bones[2]);
    skin->upper_arm_orientation = quaternion(bones[3], bones[4], bones[5], bones[6]);
    skin->forearm_position = vector(bones[7], bones[8], bones[9]);
    skin->forearm_orientation = quaternion(bones[10], bones[11], bones[12], bones[13]);
    arm_skin_initialize(skin);
    kernel->mesh = malloc(arm_skin_workspace_size(skin));
    kernel->source = calloc((size_t)skin->vertex_count * READ_ROWS, sizeof(float));
    if (status != STATUS_OK || !kernel->mesh || !kernel->source || arm_skin_check(skin, &silent) != STATUS_OK ||
        arm_skin_prepare(skin, resources, kernel->mesh, &silent) != STATUS_OK) {
        kernel_close(kernel);
        return NULL;
    }
    /* memory that was never written is one page of zeros to the processor */
    for (size_t i = 0; i < (size_t)skin->vertex_count * READ_ROWS; i++) {
        kernel->source[i] = 1.0f;
    }
    return kernel;
}

/* Row after row: what is read is added up, so that nothing of it is left out. */
INLINED void move_rows(size_t read, size_t written, const float *restrict source, size_t n, float *restrict out)
{
    for (size_t row = 0; row < written; row++) {
        const float *a = source + row * n, *b = a + written * n, *c = b + written * n, *d = c + written * n;
        float *to = out + row * n;
        if (row + 3 * written < read) {
            for (size_t i = 0; i < n; i++) {
                to[i] = (a[i] + b[i]) + (c[i] + d[i]);
            }
        } else if (row + 2 * written < read) {
            for (size_t i = 0; i < n; i++) {
                to[i] = a[i] + b[i] + c[i];
            }
        } else if (row + written < read) {
            for (size_t i = 0; i < n; i++) {
                to[i] = a[i] + b[i];
            }
        } else {
            for (size_t i = 0; i < n; i++) {
                to[i] = read ? a[i] : 1.0f;
            }
        }
    }
}

/* Six rows written: from none; from seven, those of a skin in one pass, position, normal and weight; or as an imported
 * mesh has them, three from four, then three from ten. */
INLINED void move_any(int read, const float *source, size_t n, float *out)
{
    if (read == 14) {
        move_rows(4, 3, source, n, out);
        move_rows(10, 3, source, n, out + 3 * n);
    } else if (read) {
        move_rows(7, 6, source, n, out);
    } else {
        move_rows(0, 6, source, n, out);
    }
}

IN_EVERY_INSTRUCTION_SET(move, (int read, const float *source, size_t n, float *out), move_any(read, source, n, out))

/* How many of the instruction sets binary and processor have: plain, AVX2, AVX-512. */
int kernel_levels(void)
{
    return widest_instruction_set() + 1;
}

static void deform_once(const Kernel *kernel, int level, SkinRow row, float *out)
{
    const ArmSkin *skin = &kernel->skin;
    ArmMotion pose = arm_skin_motion(skin);
    Skinning skinning = arm_skin_skinning(skin, kernel->mesh, pose.bend);
    SkinMotion motion = skin_motion_of(skin, pose.bend, skinning.widening, pose.spread);
    deform[level](skin->method, row, &motion, kernel->mesh, out);
}

long kernel_vertices(const Kernel *kernel)
{
    return (long)kernel->skin.vertex_count;
}

/* Vertices, then normals, into 6 n numbers. */
void kernel_deform(const Kernel *kernel, int level, float *out)
{
    deform_once(kernel, level, SKIN_VERTICES, out);
    deform_once(kernel, level, SKIN_NORMALS, out + 3 * kernel->skin.vertex_count);
}

/* Seconds for `count` times vertices and normals, or vertices alone. */
double kernel_seconds(const Kernel *kernel, int level, bool normals, float *out, long count)
{
    double start = now();
    for (long k = 0; k < count; k++) {
        deform_once(kernel, level, SKIN_VERTICES, out);
        if (normals) {
            deform_once(kernel, level, SKIN_NORMALS, out + 3 * kernel->skin.vertex_count);
        }
    }
    return now() - start;
}

/* Seconds for `count` times six rows written, from `read` rows: 0, 7 or 14. */
double move_seconds(const Kernel *kernel, int level, int read, float *out, long count)
{
    double start = now();
    for (long k = 0; k < count; k++) {
        move[level](read, kernel->source, (size_t)kernel->skin.vertex_count, out);
    }
    return now() - start;
}
