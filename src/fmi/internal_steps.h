/* How a communication step is divided for solvers of a fixed step. */
#ifndef ULNA_INTERNAL_STEPS_H
#define ULNA_INTERNAL_STEPS_H

#include "unit.h"

#include <math.h>

/* The least whole number of equal internal steps, none longer than `solver_step`; 0 after saying that
 * there would be more than anyone can wait for. */
static inline double internal_steps(double step, double solver_step, Log *log)
{
    static const double most = 1e9;
    /* a rounding more than a whole number is that number */
    double steps = ceil(step / solver_step * (1.0 - 1e-12));
    if (!(steps <= most)) {
        report(log, STATUS_ERROR, "solver_step = %g s divides a step of %g s in more than %g; allowed range: at least %g s",
               solver_step, step, most, step / most);
        return 0.0;
    }
    return fmax(steps, 1.0);
}

#endif
