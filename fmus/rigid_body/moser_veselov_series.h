/* The inertia with which discrete Moser-Veselov is of order 10; by tests/units/derive_moser_veselov.py.
 *
 *   1 / J = factor / I + offset
 */
#ifndef MOSER_VESELOV_SERIES_H
#define MOSER_VESELOV_SERIES_H

#include "vector.h"

typedef struct InverseInertia {
    real factor, offset;
} InverseInertia;

/* p: h^2 L.L / 2; e: h^2 times the energy; a, b, c: sum, sum of the pairs' products, product of 1 / I. */
static inline InverseInertia moser_veselov_series(real p, real e, real a, real b, real c)
{
    real factor_2 =
        p * (1.0 / 6.0 * b)
        + e * (-1.0 / 3.0 * a);
    real offset_2 =
        p * (-1.0 / 3.0 * c)
        + e * (1.0 / 6.0 * b);
    real factor_4 =
        p * p * (1.0 / 30.0 * b * b - 1.0 / 10.0 * a * c)
        + p * e * (-1.0 / 30.0 * a * b + 2.0 / 15.0 * c)
        + e * e * (1.0 / 30.0 * a * a - 1.0 / 60.0 * b);
    real offset_4 =
        p * p * (-1.0 / 60.0 * b * c)
        + p * e * (-1.0 / 60.0 * b * b + 2.0 / 15.0 * a * c)
        + e * e * (-1.0 / 60.0 * a * b - 1.0 / 10.0 * c);
    real factor_6 =
        p * p * p * (b * (17.0 / 2520.0 * b * b - 11.0 / 420.0 * a * c) + 5.0 / 126.0 * c * c)
        + p * p * e * (a * (-1.0 / 70.0 * b * b + 11.0 / 210.0 * a * c) - 1.0 / 84.0 * b * c)
        + p * e * e * (a * (1.0 / 420.0 * a * b - 53.0 / 630.0 * c) + 41.0 / 2520.0 * b * b)
        + e * e * e * (a * (-1.0 / 630.0 * a * a + 1.0 / 630.0 * b) + 1.0 / 35.0 * c);
    real offset_6 =
        p * p * p * (c * (-19.0 / 2520.0 * b * b + 1.0 / 35.0 * a * c))
        + p * p * e * (b * (1.0 / 1260.0 * b * b - 1.0 / 1260.0 * a * c) - 22.0 / 315.0 * c * c)
        + p * e * e * (a * (13.0 / 2520.0 * b * b - 8.0 / 315.0 * a * c) + 11.0 / 252.0 * b * c)
        + e * e * e * (a * (1.0 / 1260.0 * a * b + 1.0 / 42.0 * c) - 13.0 / 1260.0 * b * b);
    real factor_8 =
        p * p * p * p * (b * (b * (31.0 / 22680.0 * b * b - 19.0 / 2520.0 * a * c) + 97.0 / 15120.0 * c * c)
            + 1.0 / 120.0 * a * a * c * c)
        + p * p * p * e * (a * (b * (-11.0 / 3240.0 * b * b + 17.0 / 1260.0 * a * c) - 47.0 / 945.0 * c * c)
            + 47.0 / 7560.0 * b * b * c)
        + p * p * e * e * (a * (a * (13.0 / 3780.0 * b * b - 17.0 / 1260.0 * a * c) + 1.0 / 252.0 * b * c)
            + 1.0 / 2520.0 * b * b * b + 53.0 / 1260.0 * c * c)
        + p * e * e * e * (a * (a * (-1.0 / 11340.0 * a * b + 23.0 / 945.0 * c) - 11.0 / 1890.0 * b * b)
            - 23.0 / 1260.0 * b * c)
        + e * e * e * e * (a * (a * (1.0 / 22680.0 * a * a - 1.0 / 15120.0 * b) - 3.0 / 280.0 * c)
            + 17.0 / 5040.0 * b * b);
    real offset_8 =
        p * p * p * p * (c * (b * (-61.0 / 45360.0 * b * b + 3.0 / 560.0 * a * c) - 61.0 / 4536.0 * c * c))
        + p * p * p * e * (b * (b * (-1.0 / 45360.0 * b * b + 37.0 / 7560.0 * a * c) + 19.0 / 1260.0 * c * c)
            - 2.0 / 105.0 * a * a * c * c)
        + p * p * e * e * (a * (b * (-1.0 / 1512.0 * b * b + 19.0 / 7560.0 * a * c) + 89.0 / 1890.0 * c * c)
            - 19.0 / 1080.0 * b * b * c)
        + p * e * e * e * (a * (a * (-1.0 / 1512.0 * b * b + 8.0 / 2835.0 * a * c) - 23.0 / 1890.0 * b * c)
            + 97.0 / 22680.0 * b * b * b - 1.0 / 35.0 * c * c)
        + e * e * e * e * (a * (a * (-1.0 / 45360.0 * a * b - 1.0 / 360.0 * c) - 1.0 / 7560.0 * b * b)
            + 17.0 / 1680.0 * b * c);
    InverseInertia inverse;
    inverse.factor = 1.0 + factor_2 + factor_4 + factor_6 + factor_8;
    inverse.offset = offset_2 + offset_4 + offset_6 + offset_8;
    return inverse;
}

#endif
