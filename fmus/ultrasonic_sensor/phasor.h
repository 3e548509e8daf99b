/* UltrasonicSensor: complex numbers that stand for a carrier, by modulus and phase. */
#ifndef ULTRASONIC_SENSOR_PHASOR_H
#define ULTRASONIC_SENSOR_PHASOR_H

#include "paths.h"

#include <math.h>

typedef struct Phasor {
    double re, im;
} Phasor;

static inline Phasor scaled(double factor, Phasor a)
{
    return (Phasor){factor * a.re, factor * a.im};
}

static inline Phasor phasor_sum(Phasor a, double factor, Phasor b)
{
    return (Phasor){a.re + factor * b.re, a.im + factor * b.im};
}

static inline Phasor phasor_product(Phasor a, Phasor b)
{
    return (Phasor){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static inline double inner_product(Phasor a, Phasor b)
{
    return a.re * b.re + a.im * b.im;
}

static inline double square_of(Phasor a)
{
    return inner_product(a, a);
}

static inline Phasor phasor_quotient(Phasor a, Phasor b)
{
    return scaled(1.0 / square_of(b), phasor_product(a, (Phasor){b.re, -b.im}));
}

static inline Phasor phasor_at(double angle)
{
    return (Phasor){cos(angle), sin(angle)};
}

/* To the nearest whole number, without a branch: adding 1.5 2^52 rounds. */
static inline double rounded(double a)
{
    const double large = 6755399441055744.0;
    return (a + large) - large;
}

/* exp(-2 pi i turns) to 1e-7: both series of half the angle. */
static inline Phasor turned_back(double turns)
{
    double half = PI * (turns - rounded(turns)), h = half * half;
    double sine = half * (1.0 + h * (-1.0 / 6.0 + h * (1.0 / 120.0 + h * (-1.0 / 5040.0 + h * (1.0 / 362880.0
        + h * (-1.0 / 39916800.0))))));
    double cosine = 1.0 + h * (-1.0 / 2.0 + h * (1.0 / 24.0 + h * (-1.0 / 720.0 + h * (1.0 / 40320.0
        + h * (-1.0 / 3628800.0 + h * (1.0 / 479001600.0))))));
    return (Phasor){1.0 - 2.0 * sine * sine, -2.0 * sine * cosine};
}

#endif
