/* What the units of mechanics refuse alike. */
#ifndef ULNA_MECHANICS_CHECKS_H
#define ULNA_MECHANICS_CHECKS_H

#include "unit.h"
#include "vector.h"

#include <math.h>

static inline Status check_axis(Vector axis, Log *log)
{
    double length = norm(axis);
    if (fabs(length - 1.0) > 1e-9) {
        return report(log, STATUS_ERROR,
                      "axis = [%g, %g, %g] has length %.12g; allowed range: 1 within 1e-9, divide it by its length",
                      axis.x, axis.y, axis.z, length);
    }
    return STATUS_OK;
}

/* No mass distribution has one principal moment larger than the other two together. */
static inline Status check_inertia(Vector inertia, Log *log)
{
    const double moments[3] = {inertia.x, inertia.y, inertia.z};
    for (int i = 0; i < 3; i++) {
        double others = moments[(i + 1) % 3] + moments[(i + 2) % 3];
        if (moments[i] > others * (1.0 + 1e-9)) {
            return report(log, STATUS_ERROR,
                          "inertia[%d] = %g kg.m2 is more than the other two principal moments together (%g); "
                          "allowed range: at most their sum", i + 1, moments[i], others);
        }
    }
    return STATUS_OK;
}

#endif
