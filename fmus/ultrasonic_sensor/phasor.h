/* UltrasonicSensor: complex numbers that stand for a carrier, by modulus and phase. */
#ifndef ULTRASONIC_SENSOR_PHASOR_H
#define ULTRASONIC_SENSOR_PHASOR_H

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

#endif
