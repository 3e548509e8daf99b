/* UltrasonicSensor: the echo of a box. Each face that both ears see is a bounded plane: its mirror point, if it has it,
 * its edges and its corners, each where and when it is.
 */
#define FAINT_END 1e-6 /* of the plane's power */

enum { MOST_STRIP = 3, MOST_ENDS = MOST_STRIP * MOST_STRIP - 1 }; /* of a face, besides the mirror point */

typedef struct Face {
    Vector middle, normal, a, b; /* unit vectors, out of the box and along its sides */
    double time;                 /* of its plane's echo */
} Face;

/* A part of what a strip between -half and half reflects: its mirror point, if it has it, or an end. */
typedef struct Part {
    double place;
    double sign; /* of an end: -1 where it takes from the mirror point's echo, 1 where it is all there is; else 0 */
} Part;

static int parts_of_strip(double mirror, double half, Part parts[MOST_STRIP])
{
    int count = 0;
    if (fabs(mirror) < half) {
        parts[count++] = (Part){mirror, 0.0};
    }
    parts[count++] = (Part){-half, mirror > -half ? -1.0 : 1.0};
    parts[count++] = (Part){half, mirror < half ? -1.0 : 1.0};
    return count;
}

/* Edges and corners of a face: where its sides along a and b have their mirror point or end. */
typedef struct Ends {
    int count;
    double place_a[MOST_ENDS], sign_a[MOST_ENDS], place_b[MOST_ENDS], sign_b[MOST_ENDS];
} Ends;

/* What they echo. */
typedef struct EndEchoes {
    double length[MOST_ENDS];            /* of the path */
    double clear[MOST_ENDS];             /* above 0 where both ears are in front */
    double power[MOST_ENDS];             /* in shares of the plane's */
    double re[MOST_ENDS], im[MOST_ENDS]; /* strength, without the air's loss, and */
    double modulus[MOST_ENDS];
    double there[MOST_ENDS], back[MOST_ENDS], doppler[MOST_ENDS];
} EndEchoes;

/* Of a side bent by `bend` that meets the sound at `slope`. */
INLINED Phasor weight_of_side(double slope, double bend, double sign, double wave_number)
{
    Phasor end = end_of_mirror(fabs(slope) * sqrt(wave_number / (PI * bend)));
    return (Phasor){(1.0 - sign * sign) + sign * end.re, sign * end.im};
}

/* One loop without a branch, so that the compiler takes several ends at a time. */
INLINED void echoes_of_ends(const UltrasonicSensor *sensor, const Transceiver *pair, const Face *restrict face,
                            const Ends *restrict ends, EndEchoes *restrict echoes)
{
    const double speed = sensor->speed_of_sound, k = sensor->wave_number, reflection = sensor->box_reflection;
    const Vector a = face->a, b = face->b;
    const Transceiver ears = *pair;
    for (int i = 0; i < MOST_ENDS; i++) {
        Vector point = add_scaled(add_scaled(face->middle, ends->place_a[i], a), ends->place_b[i], b);
        Path path = path_by(&ears, point, face->normal, face->time, speed);
        double near = 1.0 / path.first, far = 1.0 / path.second;
        double there_a = dot(path.incident, a), there_b = dot(path.incident, b);
        double back_a = dot(path.reflected, a), back_b = dot(path.reflected, b);
        double bend_a = (1.0 - there_a * there_a) * near + (1.0 - back_a * back_a) * far;
        double bend_b = (1.0 - there_b * there_b) * near + (1.0 - back_b * back_b) * far;
        Phasor weight = phasor_product(weight_of_side(there_a - back_a, bend_a, ends->sign_a[i], k),
                                       weight_of_side(there_b - back_b, bend_b, ends->sign_b[i], k));
        /* Kirchhoff's obliquity over the size of the zone that answers; 1 at the mirror point */
        double fall = -dot(path.incident, face->normal), rise = dot(path.reflected, face->normal);
        weight = scaled(0.5 * (fall + rise) * (near + far) / sqrt(bend_a * bend_b), weight);
        double length = path.first + path.second;
        double amplitude = lossless_amplitude(&ears, path, length, reflection, k);
        double front = lesser(dot(path.incident, ears.axis), -dot(path.reflected, ears.receiver_axis));
        echoes->length[i] = length;
        echoes->clear[i] = lesser(front, lesser(fall, rise));
        echoes->power[i] = square_of(weight);
        echoes->modulus[i] = fabs(amplitude) * sqrt(square_of(weight));
        echoes->re[i] = amplitude * weight.re;
        echoes->im[i] = amplitude * weight.im;
        echoes->there[i] = beam_argument(path.incident, ears.axis, k);
        echoes->back[i] = beam_argument(path.reflected, ears.receiver_axis, k);
        echoes->doppler[i] = doppler_of(&ears, path, at_rest, speed);
    }
}

/* The same operations, two, four or eight ends at a time. */
IN_EVERY_INSTRUCTION_SET(hear_ends, (const UltrasonicSensor *sensor, const Transceiver *pair, const Face *restrict face,
                                     const Ends *restrict ends, EndEchoes *restrict echoes),
                         echoes_of_ends(sensor, pair, face, ends, echoes))

/* All parts but the mirror point. */
static void find_ends(const Part *along_a, int count_a, const Part *along_b, int count_b, Ends *ends)
{
    for (int j = 0; j < count_b; j++) {
        for (int i = 0; i < count_a; i++) {
            if (along_a[i].sign != 0.0 || along_b[j].sign != 0.0) {
                int k = ends->count++;
                ends->place_a[k] = along_a[i].place;
                ends->sign_a[k] = along_a[i].sign;
                ends->place_b[k] = along_b[j].place;
                ends->sign_b[k] = along_b[j].sign;
            }
        }
    }
}

/* Past all else; false behind a solid plane. */
static bool hear_from_box(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair,
                          const Path *path, Echo *echo)
{
    return !behind_plane(around, path->point)
        && (alone(around, BOX) || hear_shaded(sensor, around, pair, BOX, path, path->first + path->second, echo));
}

static Path path_by_end(const Transceiver *pair, const Face *face, const Ends *ends, int i, double speed)
{
    Vector point = add_scaled(add_scaled(face->middle, ends->place_a[i], face->a), ends->place_b[i], face->b);
    return path_by(pair, point, face->normal, face->time, speed);
}

static void add_ends(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair,
                     const Face *face, const Ends *ends, Echoes *echoes)
{
    bool nothing_else = !around->plane && alone(around, BOX);
    double speed = sensor->speed_of_sound;
    EndEchoes found;
    hear_ends[widest_instruction_set()](sensor, pair, face, ends, &found);
    for (int i = 0; i < ends->count; i++) {
        if (found.clear[i] > 0.0 && found.power[i] >= FAINT_END) {
            double air = left_by_air(found.length[i], sensor->absorption);
            Echo *echo = next_echo(echoes);
            *echo = (Echo){.time = found.length[i] / speed,
                           .strength = {air * found.re[i], air * found.im[i]},
                           .amplitude = air * found.modulus[i],
                           .there = found.there[i],
                           .back = found.back[i],
                           .doppler = found.doppler[i]};
            bool heard = nothing_else;
            if (!nothing_else) {
                Path path = path_by_end(pair, face, ends, i, speed);
                heard = hear_from_box(sensor, around, pair, &path, echo);
            }
            keep_next(echoes, heard);
        }
    }
}

static void add_face(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair, int across,
                     double side, Echoes *echoes)
{
    const Box *box = &around->box;
    int first = (across + 1) % AXES, second = (across + 2) % AXES;
    Face face = {.normal = scale(side, box->axis[across]), .a = box->axis[first], .b = box->axis[second]};
    face.middle = add_scaled(box->center, box->half[across], face.normal);
    Path mirror = plane_path(pair, face.middle, face.normal, sensor->speed_of_sound);
    Vector offset = subtract(mirror.point, face.middle);
    Part along_a[MOST_STRIP], along_b[MOST_STRIP];
    int count_a = parts_of_strip(dot(offset, face.a), box->half[first], along_a);
    int count_b = parts_of_strip(dot(offset, face.b), box->half[second], along_b);
    if (along_a[0].sign == 0.0 && along_b[0].sign == 0.0) {
        Echo *echo = next_echo(echoes);
        double spread = mirror.first + mirror.second;
        keep_next(echoes, hear_path(sensor, pair, &mirror, spread, at_rest, sensor->box_reflection, echo)
                              && hear_from_box(sensor, around, pair, &mirror, echo));
    }
    face.time = mirror.time;
    Ends ends = {.count = 0}; /* what is not one of them is computed all the same, at the middle */
    find_ends(along_a, count_a, along_b, count_b, &ends);
    add_ends(sensor, around, pair, &face, &ends, echoes);
}

static void add_box(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair, Echoes *echoes)
{
    const Box *box = &around->box;
    Vector there = subtract(pair->transmitter, box->center), back = subtract(pair->receiver, box->center);
    for (int i = 0; i < AXES && sensor->box_reflection > 0.0; i++) {
        double one = dot(there, box->axis[i]), other = dot(back, box->axis[i]);
        bool above = lesser(one, other) > box->half[i], below = greater(one, other) < -box->half[i];
        if (above || below) {
            add_face(sensor, around, pair, i, above ? 1.0 : -1.0, echoes);
        }
    }
}
