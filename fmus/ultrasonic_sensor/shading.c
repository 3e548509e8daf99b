/* UltrasonicSensor: what bodies beside or across the way of a sound leave of it.
 *
 * A body is a screen across the leg, a rectangle of its outline, and hides from the sound what Fresnel's
 * integrals say of its two widths: with the distances d1 from the ear and d2 to where the wavefront behind
 * the body comes together again,
 *
 *     passed = 1 - A B,  A = 1 - tail(h + q) - tail(h - q)       h half a width, q its offset from the leg
 *     tail(s) = exp(-i pi u^2 / 2) e(u),  u = s sqrt(k (1 / d1 + 1 / d2) / pi)         e of fresnel.c
 *
 * Kirchhoff's diffraction; Born and Wolf, Principles of Optics, 8.7 and 8.8.
 */
#define LIT 2.0      /* Fresnel's u of a clearance from which a screen's ripple is faded out: */
#define FAR_LIT 4.0  /* a round body has none there, and an endless one would cost every ping */
#define TOUCHING 1e-9 /* of the radius: where two bodies share a point of their skins, the first has it */

/* A body as seen along a leg. */
typedef struct Screen {
    double along;          /* from the ear */
    double depth;          /* half of the body's */
    double offset[2], half[2];
} Screen;

static Screen screen_of_target(const Target *target, Vector from, Vector leg, double when)
{
    Vector drift = scale(when, target->velocity);
    Vector whole = subtract(target->end, target->start);
    Vector middle = subtract(add_scaled(add(target->start, drift), 0.5, whole), from);
    Vector flat = add_scaled(whole, -dot(whole, leg), leg), aside = add_scaled(middle, -dot(middle, leg), leg);
    double length = norm(flat), off = norm(aside), radius = target->radius;
    Screen screen = {.along = dot(middle, leg), .depth = radius};
    /* half of a round end's width on average; its whole area is that of the circle */
    screen.half[0] = 0.5 * length + 0.25 * PI * radius;
    screen.half[1] = radius;
    if (!(length > 0.0)) {
        screen.offset[0] = 0.0;
        screen.offset[1] = off;
        return screen;
    }
    Vector axis = scale(1.0 / length, flat);
    screen.offset[0] = dot(aside, axis);
    screen.offset[1] = dot(aside, cross(leg, axis));
    /* where the leg passes the axis */
    double share = lesser(greater(-screen.offset[0] / length, -0.5), 0.5);
    screen.along += share * dot(whole, leg);
    return screen;
}

static Screen screen_of_box(const Box *box, Vector from, Vector leg)
{
    Vector center = subtract(box->center, from), axis = leg;
    double longest = 0.0;
    Screen screen = {.along = dot(center, leg)};
    for (int i = 0; i < AXES; i++) {
        Vector flat = add_scaled(box->axis[i], -dot(box->axis[i], leg), leg);
        double size = norm(flat);
        axis = box->half[i] * size > longest ? scale(1.0 / size, flat) : axis;
        longest = greater(box->half[i] * size, longest);
    }
    Vector across = cross(leg, axis);
    screen.offset[0] = dot(center, axis);
    screen.offset[1] = dot(center, across);
    for (int i = 0; i < AXES; i++) {
        screen.depth += box->half[i] * fabs(dot(box->axis[i], leg));
        screen.half[0] += box->half[i] * fabs(dot(box->axis[i], axis));
        screen.half[1] += box->half[i] * fabs(dot(box->axis[i], across));
    }
    return screen;
}

/* Beyond the four sides of a screen, the shares of a wavefront that pass there; `beyond` from the leg to each. */
typedef struct Tails {
    double beyond[4];
    double re[4], im[4];
} Tails;

INLINED void tails_beyond(double unit, Tails *restrict tails)
{
    for (int i = 0; i < 4; i++) {
        double u = fabs(tails->beyond[i]) * unit, sign = copysign(1.0, tails->beyond[i]);
        Phasor end = phasor_product(end_of_mirror(u), turned_back(0.25 * u * u));
        tails->re[i] = 0.5 * (1.0 - sign) + sign * end.re;
        tails->im[i] = sign * end.im;
    }
}

/* The same operations, two or four sides at a time. */
IN_EVERY_INSTRUCTION_SET(find_tails, (double unit, Tails *restrict tails), tails_beyond(unit, tails))

static Phasor covered_by(Screen screen, double unit)
{
    Tails tails = {.beyond = {screen.half[0] + screen.offset[0], screen.half[0] - screen.offset[0],
                              screen.half[1] + screen.offset[1], screen.half[1] - screen.offset[1]}};
    find_tails[widest_instruction_set()](unit, &tails);
    Phasor wide = {1.0 - tails.re[0] - tails.re[1], -tails.im[0] - tails.im[1]};
    Phasor high = {1.0 - tails.re[2] - tails.re[3], -tails.im[2] - tails.im[3]};
    return phasor_product(wide, high);
}

/* What a screen leaves of the sound on a leg that is `reach` long, whose wavefront comes together `focus` behind
 * its end. Beside one end of the leg it counts for less: it then shades but a part of what is met there. */
static Phasor passed(Screen screen, double reach, double focus, double wave_number)
{
    double rest = reach - screen.along;
    if (screen.along <= 0.0 || rest <= 0.0) {
        return (Phasor){1.0, 0.0};
    }
    double unit = sqrt(wave_number / PI * (1.0 / screen.along + 1.0 / (rest + focus)));
    double clear = unit * greater(fabs(screen.offset[0]) - screen.half[0], fabs(screen.offset[1]) - screen.half[1]);
    if (clear >= FAR_LIT) {
        return (Phasor){1.0, 0.0};
    }
    double weight = lesser(1.0, (FAR_LIT - clear) / (FAR_LIT - LIT));
    weight *= lesser(1.0, lesser(screen.along, rest) / screen.depth);
    Phasor hidden = covered_by(screen, unit);
    return (Phasor){1.0 - weight * hidden.re, -weight * hidden.im};
}

/* Its phasor times `factor`. */
static void weigh(Echo *echo, Phasor factor)
{
    echo->strength = phasor_product(factor, echo->strength);
    echo->amplitude = sqrt(square_of(echo->strength));
}

static Vector mirrored(const Surroundings *around, Vector point)
{
    double height = dot(subtract(point, around->plane_point), around->plane_normal);
    return add_scaled(point, -2.0 * height, around->plane_normal);
}

static Vector turned_over(const Surroundings *around, Vector direction)
{
    return add_scaled(direction, -2.0 * dot(direction, around->plane_normal), around->plane_normal);
}

static Target mirrored_target(const Surroundings *around, const Target *target)
{
    return (Target){mirrored(around, target->start), mirrored(around, target->end),
                    turned_over(around, target->velocity), target->radius, target->reflection};
}

static Box mirrored_box(const Surroundings *around)
{
    Box box = around->box;
    box.center = mirrored(around, box.center);
    for (int i = 0; i < AXES; i++) {
        box.axis[i] = turned_over(around, box.axis[i]);
    }
    return box;
}

/* A straight way from an ear to a point that echoes. */
typedef struct Leg {
    Vector from, direction;
    double reach, focus; /* of the focus only a bound is needed to see that nothing is near */
    double begin, pace;  /* it is `along` from the ear at begin + pace along, from the emission */
} Leg;

enum { PLANE = -1, BOX = MOST_TARGETS }; /* besides the targets' numbers */

/* Where the middle of a body is when the sound passes it, from the ear; as far along the leg as the second says. */
static Vector middle_of(const Leg *leg, const Target *target, double *along)
{
    Vector offset = subtract(scale(0.5, add(target->start, target->end)), leg->from);
    *along = dot(offset, leg->direction);
    return add_scaled(offset, leg->begin + leg->pace * *along, target->velocity);
}

/* Whether `passed` would leave all of the sound beside a body, on any way within `slack` of the leg: its screen is
 * FAR_LIT off the leg on one of its two widths. That is farthest half way to the focus. */
static bool clear_of(const Leg *leg, const Target *target, double slack, double wave_number)
{
    double along;
    Vector offset = middle_of(leg, target, &along), whole = subtract(target->end, target->start);
    along = dot(offset, leg->direction);
    double slant = dot(whole, leg->direction), depth = 0.5 * fabs(slant) + target->radius + slack;
    if (along > leg->reach + depth || along < -depth) {
        return true;
    }
    double span = leg->reach + leg->focus;
    double widest = lesser(greater(0.5 * span, along - depth), along + depth);
    double zone = slack + FAR_LIT * sqrt(greater(widest * (span - widest), 0.0) * (PI / (wave_number * span)));
    double near = target->radius + zone, flat_square = dot(whole, whole) - slant * slant;
    if (!(flat_square > 0.0)) {
        return dot(offset, offset) - along * along > near * near;
    }
    double across = dot(offset, cross(leg->direction, whole));
    double beyond = fabs(dot(offset, whole) - along * slant) - 0.5 * flat_square;
    double end = 0.25 * PI * target->radius + zone;
    return across * across > near * near * flat_square || (beyond > 0.0 && beyond * beyond > end * end * flat_square);
}

/* A solid plane hides what lies there. A leg that begins there is from the image of an ear, among those of the bodies. */
static bool behind_plane(const Surroundings *around, Vector point)
{
    return around->plane && dot(subtract(point, around->plane_point), around->plane_normal) < 0.0;
}

/* Both legs at a time, as the two ends and motions lie apart, or one by one. */
static bool clear_of_both(const Leg *there, const Leg *back, const Target *target, double wave_number)
{
    double slack = most_of(subtract(back->from, there->from)) + back->begin * most_of(target->velocity);
    return clear_of(there, target, slack, wave_number)
        || (clear_of(there, target, 0.0, wave_number) && clear_of(back, target, 0.0, wave_number));
}

/* Whether no body but `own` is near a path. */
static bool clear_of_all(const Surroundings *around, const Leg *there, const Leg *back, int own, double wave_number)
{
    if (behind_plane(around, there->from) || behind_plane(around, back->from)) {
        return false;
    }
    for (int i = 0; i < around->targets; i++) {
        if (i != own && !clear_of_both(there, back, &around->target[i], wave_number)) {
            return false;
        }
    }
    const Target ball = {.start = around->box.center, .end = around->box.center, .radius = around->box.extent};
    return !around->box_present || own == BOX || clear_of_both(there, back, &ball, wave_number);
}

/* What all bodies but `own` leave on a leg. */
static Phasor passed_by_all(const Surroundings *around, const Leg *leg, int own, double wave_number)
{
    Phasor whole = {1.0, 0.0};
    for (int side = 0; side < (behind_plane(around, leg->from) ? 2 : 1); side++) {
        for (int i = 0; i < around->targets; i++) {
            Target target = side ? mirrored_target(around, &around->target[i]) : around->target[i];
            if ((i != own || side) && !clear_of(leg, &target, 0.0, wave_number)) {
                double along;
                middle_of(leg, &target, &along);
                Screen screen = screen_of_target(&target, leg->from, leg->direction, leg->begin + leg->pace * along);
                whole = phasor_product(whole, passed(screen, leg->reach, leg->focus, wave_number));
            }
        }
        if (around->box_present && (own != BOX || side)) {
            Box box = side ? mirrored_box(around) : around->box;
            Screen screen = screen_of_box(&box, leg->from, leg->direction);
            whole = phasor_product(whole, passed(screen, leg->reach, leg->focus, wave_number));
        }
    }
    return whole;
}

/* Whether the point lies in another body. */
static bool buried(const Surroundings *around, Vector point, double when, int own)
{
    for (int i = 0; i < around->targets; i++) {
        Target target = around->target[i];
        Vector here = add_scaled(point, -when, target.velocity);
        double reach = norm(subtract(here, axis_point(&target, nearest_share(&target, here))));
        if (i != own && reach < target.radius * (i < own ? 1.0 + TOUCHING : 1.0 - TOUCHING)) {
            return true;
        }
    }
    bool inside = around->box_present && own != BOX;
    for (int i = 0; i < AXES && inside; i++) {
        inside = fabs(dot(subtract(point, around->box.center), around->box.axis[i])) < around->box.half[i];
    }
    return inside;
}

/* Whether no body besides `own` can shade it. */
static bool alone(const Surroundings *around, int own)
{
    return around->targets + around->box_present == (own != PLANE);
}

/* Weighs an echo by body `own` with what is left of it behind and beside the others; false for nothing. */
static bool hear_shaded(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair, int own,
                        const Path *path, double spread, Echo *echo)
{
    double slow = 1.0 / sensor->speed_of_sound;
    Vector receiver = add_scaled(pair->receiver, path->time, pair->velocity);
    /* no wavefront comes together farther off than where the other leg ends */
    Leg there = {pair->transmitter, path->incident, path->first, path->second, 0.0, slow};
    Leg back = {receiver, scale(-1.0, path->reflected), path->second, path->first, path->time, -slow};
    if (clear_of_all(around, &there, &back, own, sensor->wave_number)) {
        return true;
    }
    if (buried(around, path->point, path->bounce_time, own)) {
        return false;
    }
    /* the mean curvature that the mirror adds, from the spreading */
    double whole = path->first + path->second, added = (spread - whole) / (path->first * path->second);
    there.focus = 1.0 / (added + 1.0 / path->second);
    back.focus = 1.0 / (added + 1.0 / path->first);
    Phasor factor = phasor_product(passed_by_all(around, &there, own, sensor->wave_number),
                                   passed_by_all(around, &back, own, sensor->wave_number));
    if (factor.re != 1.0 || factor.im != 0.0) {
        weigh(echo, factor);
    }
    return true;
}
