/* The free rigid body in closed form: its attitude at any time, from constants set up once.
 *
 * In canonical axes (z the extreme axis whose momentum never vanishes, y the middle one, all signs
 * such that x and z are not negative at the start) the momentum over its norm is
 *     (A_x cn u, A_y sn u, A_z dn u),   u = u0 + lambda t.
 * From a frame with L on its third axis the attitude is the quaternion alpha + beta i, of two numbers
 * that are complex in k. Both are entire in u but for one common real factor, which the norm takes out:
 *     alpha ~ exp(i mu t) theta4(v - i b, q^2),   beta ~ exp(i mu t) theta1(v - i b, q^2),
 * v = pi u / 2K, q the nome of the momentum, b = pi s / 2K and cd(s, k') = A_z. The zeros of theta4
 * and theta1 are zeros of 1 + A_z dn u and of 1 - A_z dn u: those where the phase of alpha,
 *     d arg(alpha) / dt = (a_z L + (2 E - a_z L^2) / (L + m_z)) / 2,   a = 1 / I,
 * has a pole of the same residue; its value at u = 0 gives mu. No angle is unwound, and no integral of
 * the third kind is left.
 *
 * Near the separatrix q tends to 1 and Jacobi's imaginary transformation takes over: hyperbolic
 * functions of the distance from the nearest turn. In both forms the terms fall as exp(-pi n^2) or
 * faster. Symmetric, spherical and steady bodies need no other formula: there k = 0.
 *
 * The same motion with its integral of the third kind: van Zon & Schofield, J. Comput. Phys. 225:145 (2007).
 */
#include "equations.h"
#include "elliptic.c"

#include <stdbool.h>

enum { DIRECT_TERMS = 8, COMPLEMENTARY_TERMS = 4 };

typedef struct FreeMotion {
    double start, rate;         /* of the phase: v in the direct form, u in the complementary one */
    double precession_rate;     /* mu, rad/s */
    double cosine[DIRECT_TERMS], sine[DIRECT_TERMS]; /* coefficients of the terms */
    Quaternion basis[4];        /* what 1, x, y, z of the canonical quaternion are in the world */
    /* of the complementary form only */
    double turn;                /* 2 K: u from one turn to the next; 0 marks the direct form */
    double precession_by_phase; /* rad per unit of u that the transformation takes out of theta */
    double exponent_by_phase;   /* pi / 2 K' */
    double nome;                /* exp(-pi K / 2 K') */
} FreeMotion;

/* The momentum in canonical axes, over its norm, and the ratios of the inertia. */
typedef struct Canonical {
    double x, y, z;                   /* momentum over its norm, x and z not negative */
    double middle, rest;              /* (a_y - a_z) / (a_x - a_z), and 1 minus that */
    double complement;                /* middle z^2 - rest x^2: the distance from the separatrix */
    double rate_x, rate_z;            /* a_x L and a_z L, rad/s */
    double rate_difference;           /* (a_x - a_z) L, rad/s */
    Vector axes[3];                   /* x, y, z in body axes */
} Canonical;

/* A product kept with its rounding. */
typedef struct Product {
    double high, low;
} Product;

static Product times(Product a, double b)
{
    Product product;
    product.high = a.high * b;
    product.low = fma(a.high, b, -product.high) + a.low * b;
    return product;
}

static Product exact_difference(double a, double b)
{
    Product difference;
    difference.high = a - b;
    double taken = a - difference.high;
    difference.low = (a - (difference.high + taken)) + (taken - b);
    return difference;
}

/* I_low (I_high - I_middle) m_high^2 - I_high (I_middle - I_low) m_low^2, of the sign of L^2 - 2 E I_middle:
 * every product to twice the digits, since near the separatrix all that is left is their rounding. */
static double separatrix_distance(const double inertia[3], const double m[3], const int order[3])
{
    int low = order[0], middle = order[1], high = order[2];
    Product a = times(exact_difference(inertia[high], inertia[middle]), inertia[low]);
    Product b = times(exact_difference(inertia[middle], inertia[low]), inertia[high]);
    a = times(times(a, m[high]), m[high]);
    b = times(times(b, m[low]), m[low]);
    return (a.high - b.high) + (a.low - b.low);
}

static void order_by_inertia(const double inertia[3], int order[3])
{
    for (int i = 0; i < 3; i++) {
        int rank = 0;
        for (int j = 0; j < 3; j++) {
            rank += inertia[j] < inertia[i] || (inertia[j] == inertia[i] && j < i);
        }
        order[rank] = i;
    }
}

/* No torque of its own: w along L, by symmetry or about a principal axis. */
static bool is_steady(const double inertia[3], const double n[3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        if ((inertia[i] - inertia[j]) * n[i] * n[j] != 0.0) {
            return false;
        }
    }
    return true;
}

static Canonical canonical_form(Vector principal, Vector m, double L)
{
    const double inertia[3] = {principal.x, principal.y, principal.z};
    const double momentum[3] = {m.x, m.y, m.z};
    const double n[3] = {m.x / L, m.y / L, m.z / L};
    int order[3];
    Canonical form;
    int x, y, z;
    order_by_inertia(inertia, order);
    if (is_steady(inertia, n)) {
        z = fabs(n[0]) > fabs(n[1]) ? 0 : 1;
        z = fabs(n[2]) > fabs(n[z]) ? 2 : z;
        x = (z + 1) % 3;
        y = (z + 2) % 3;
        form.middle = 1.0;
        form.rest = 0.0;
        form.rate_difference = 0.0;
        form.complement = n[z] * n[z];
        form.rate_x = L / inertia[z];
    } else {
        double distance = separatrix_distance(inertia, momentum, order);
        x = order[distance < 0.0 ? 2 : 0];
        y = order[1];
        z = order[distance < 0.0 ? 0 : 2];
        double span = (inertia[z] - inertia[x]) * inertia[y];
        form.middle = (inertia[z] - inertia[y]) * inertia[x] / span;
        form.rest = (inertia[y] - inertia[x]) * inertia[z] / span;
        form.rate_difference = L * (inertia[z] - inertia[x]) / (inertia[x] * inertia[z]);
        form.complement = fabs(distance / span) / (L * L);
        form.rate_x = L / inertia[x];
    }
    form.rate_z = L / inertia[z];
    double axis[3][3] = {{0.0}};
    axis[0][x] = copysign(1.0, n[x]);
    axis[2][z] = copysign(1.0, n[z]);
    form.axes[0] = vector(axis[0][0], axis[0][1], axis[0][2]);
    form.axes[2] = vector(axis[2][0], axis[2][1], axis[2][2]);
    form.axes[1] = cross(form.axes[2], form.axes[0]);
    form.x = fabs(n[x]);
    form.y = dot(form.axes[1], vector(n[0], n[1], n[2]));
    form.z = fabs(n[z]);
    return form;
}

/* alpha and beta without their common precession and norm. */
static Quaternion direct_attitude(const FreeMotion *motion, double v)
{
    double c1 = cos(v), s1 = sin(v), c = 1.0, s = 0.0;
    Quaternion sum = {1.0, 0.0, 0.0, 0.0};
    for (int j = 1; j < DIRECT_TERMS; j += 2) {
        double next = c * c1 - s * s1;
        s = s * c1 + c * s1;
        c = next;
        sum.x += motion->cosine[j] * s;
        sum.y -= motion->sine[j] * c;
        if (j + 1 < DIRECT_TERMS) {
            next = c * c1 - s * s1;
            s = s * c1 + c * s1;
            c = next;
            sum.w += motion->cosine[j + 1] * c;
            sum.z += motion->sine[j + 1] * s;
        }
    }
    return sum;
}

static Quaternion complementary_attitude(const FreeMotion *motion, double u)
{
    double decay = exp(-fmin(fabs(u) * motion->exponent_by_phase, 700.0));
    double growth_ratio = motion->nome / decay, decay_ratio = motion->nome * decay;
    double growing = 1.0, decaying = decay, sign = 1.0;
    Quaternion sum = {0.0, 0.0, 0.0, 0.0};
    for (int n = 0; n < COMPLEMENTARY_TERMS; n++) {
        double even = growing + decaying, odd = copysign(growing - decaying, u);
        sum.w += motion->cosine[n] * even;
        sum.z -= motion->sine[n] * odd;
        sum.x += sign * motion->cosine[n] * odd;
        sum.y -= sign * motion->sine[n] * even;
        growing *= growth_ratio;
        decaying *= decay_ratio;
        sign = -sign;
    }
    return sum;
}

/* alpha and beta, unit norm. */
static Quaternion canonical_attitude(const FreeMotion *motion, double t)
{
    double phase = motion->start + motion->rate * t;
    double precession = motion->precession_rate * t;
    Quaternion a;
    if (motion->turn > 0.0) {
        double turns = floor(phase / motion->turn + 0.5);
        double u = phase - turns * motion->turn;
        a = complementary_attitude(motion, u);
        precession += motion->precession_by_phase * u;
        if (turns - 2.0 * floor(0.5 * turns) > 0.5) {
            a.x = -a.x;
            a.y = -a.y;
        }
    } else {
        a = direct_attitude(motion, phase);
    }
    double size = 1.0 / sqrt(quaternion_square(a));
    double c = size * cos(precession), s = size * sin(precession);
    return quaternion(a.w * c - a.z * s, a.x * c - a.y * s, a.y * c + a.x * s, a.z * c + a.w * s);
}

/* The canonical quaternion a, its four parts taken to what they are in the basis. */
static inline Quaternion in_world(const Quaternion basis[4], Quaternion a)
{
    Quaternion q = {0.0, 0.0, 0.0, 0.0};
    q = add_scaled_quaternion(q, a.w, basis[0]);
    q = add_scaled_quaternion(q, a.x, basis[1]);
    q = add_scaled_quaternion(q, a.y, basis[2]);
    return add_scaled_quaternion(q, a.z, basis[3]);
}

/* Chooses the basis such that the motion starts from q0. */
static void set_basis(FreeMotion *motion, const Vector axes[3], Quaternion q0)
{
    Quaternion units[4] = {{1.0, 0.0, 0.0, 0.0}};
    for (int i = 0; i < 3; i++) {
        units[i + 1] = quaternion(0.0, axes[i].x, axes[i].y, axes[i].z);
    }
    Quaternion start = in_world(units, canonical_attitude(motion, 0.0));
    Quaternion frame = normalized(compose(q0, conjugate(start)));
    for (int i = 0; i < 4; i++) {
        motion->basis[i] = compose(frame, units[i]);
    }
}

/* What both forms start from. */
typedef struct Amplitudes {
    double x2, z2, x, z;                /* A_x^2, A_z^2, whose sum is 1, and their roots */
    double k2;                          /* the modulus squared */
    double quarter, conjugate_quarter;  /* K and K' */
    double u, rate;                     /* at t = 0 */
    double attitude_rate;               /* d arg(alpha) / dt at u = 0, rad/s */
} Amplitudes;

static Amplitudes amplitudes(const Canonical *n)
{
    Amplitudes a;
    a.x2 = n->x * n->x + n->middle * n->y * n->y;
    a.z2 = n->z * n->z + n->rest * n->y * n->y;
    a.x = sqrt(a.x2);
    a.z = sqrt(a.z2);
    a.k2 = n->rest * a.x2 / (n->middle * a.z2);
    a.quarter = complete_elliptic(sqrt(n->complement / (n->middle * a.z2)));
    a.conjugate_quarter = complete_elliptic(sqrt(a.k2));
    a.u = n->y == 0.0 ? 0.0 : sqrt(n->middle) * n->y / a.x * carlson_rf(n->x * n->x / a.x2, n->z * n->z / a.z2, 1.0);
    a.rate = n->rate_difference * sqrt(n->middle) * a.z;
    /* the rate of the comment above, as a sum of like signs: A_x^2 / (1 + A_z) is 1 - A_z */
    a.attitude_rate = 0.5 * (n->rate_z * a.z + n->rate_x * a.x2 / (1.0 + a.z));
    return a;
}

/* Terms j = -7 .. 7 of theta4 (j even) and theta1 (j odd): g^j q^(j (j - 1) / 2) exp(i j v), g = exp(b) sqrt(q). */
static void set_direct(FreeMotion *motion, const Amplitudes *a)
{
    double gap = a->x > 0.0 ? a->z * carlson_rf(a->x2, a->x2 + a->k2 * a->z2, 1.0) : INFINITY; /* K' - s */
    double q = exp(-pi * a->conjugate_quarter / a->quarter);
    double g = exp(-0.5 * pi * gap / a->quarter);
    double back = q / fmax(g, DBL_MIN); /* below sqrt(q); g = 0 where there is but one frequency */
    double forward_term = 1.0, back_term = 1.0, power = 1.0, even = 1.0, odd = 0.0;
    motion->cosine[0] = 1.0;
    for (int j = 1; j < DIRECT_TERMS; j++) {
        forward_term *= g * power;
        back_term *= back * power;
        power *= q;
        double sign = j / 2 % 2 ? -1.0 : 1.0;
        motion->cosine[j] = sign * (forward_term + back_term);
        motion->sine[j] = sign * (forward_term - back_term);
        even += j % 2 ? 0.0 : motion->cosine[j];
        odd += j % 2 ? 0.0 : j * motion->sine[j];
    }
    motion->start = 0.5 * pi * a->u / a->quarter;
    motion->rate = 0.5 * pi * a->rate / a->quarter;
    motion->precession_rate = a->attitude_rate - motion->rate * odd / even;
}

/* Terms n = 0 .. 3 of theta2 and theta1 of the complementary nome, without their hyperbolic functions. */
static void set_complementary(FreeMotion *motion, const Amplitudes *a)
{
    double s = a->x * carlson_rf(a->k2 * a->z2, a->k2, a->x2 + a->k2 * a->z2);
    double angle = 0.25 * pi * s / a->conjugate_quarter;
    double power = 1.0, even = 0.0, odd = 0.0; /* power: nome^n */
    double square = 1.0;                       /* nome^(n^2) */
    motion->nome = exp(-0.5 * pi * a->quarter / a->conjugate_quarter);
    for (int n = 0; n < COMPLEMENTARY_TERMS; n++) {
        motion->cosine[n] = square * cos((2 * n + 1) * angle);
        motion->sine[n] = square * sin((2 * n + 1) * angle);
        even += power * motion->cosine[n];
        odd += power * (2 * n + 1) * motion->sine[n];
        square *= power * power * motion->nome;
        power *= motion->nome;
    }
    motion->start = a->u;
    motion->rate = a->rate;
    motion->turn = fmin(2.0 * a->quarter, DBL_MAX); /* no second turn on the separatrix itself */
    motion->exponent_by_phase = 0.5 * pi / a->conjugate_quarter;
    motion->precession_by_phase = angle / a->quarter;
    motion->precession_rate = a->attitude_rate
                              + a->rate * (0.5 * motion->exponent_by_phase * odd / even - motion->precession_by_phase);
}

/* The free motion from attitude q0 with the angular momentum L (world), at t = 0. */
static FreeMotion free_motion_setup(Vector inertia, Quaternion q0, Vector angular_momentum)
{
    FreeMotion motion = {0};
    Vector m = rotate_back(q0, angular_momentum);
    double L = norm(m);
    if (!(L > 0.0)) { /* at rest */
        motion.cosine[0] = 1.0;
        motion.basis[0] = normalized(q0);
        return motion;
    }
    Canonical form = canonical_form(inertia, m, L);
    Amplitudes a = amplitudes(&form);
    if (a.conjugate_quarter < 0.5 * a.quarter) {
        set_complementary(&motion, &a);
    } else {
        set_direct(&motion, &a);
    }
    set_basis(&motion, form.axes, q0);
    return motion;
}

/* Body to world, t seconds after the set-up; unit norm, and continuous in t, its sign included. */
static inline Quaternion free_motion_attitude(const FreeMotion *motion, double t)
{
    return in_world(motion->basis, canonical_attitude(motion, t));
}
