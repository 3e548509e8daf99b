/* Adjoint derivatives, for FMI 3. */
#include "instance.h"

#include <string.h>

/* One column of the Jacobian a known, so that the transposed product needs no second set of equations. */
static Status instance_adjoint_derivative(Instance *instance, const char *call, References unknowns, References knowns,
                                          const double *seed, size_t seed_count, double *result, size_t result_count)
{
    uint32_t groups;
    Status status = prepare_derivatives(instance, call, unknowns, seed_count, knowns, result_count, &groups);
    double *direction = instance->by_reference + unit.reference_count;
    const double *sensitivity = direction + unit.reference_count;
    for (size_t i = 0, column = 0; status == STATUS_OK && i < knowns.count; i++) {
        for (uint32_t k = 0; k < elements_of(knowns, i); k++) {
            memset(direction, 0, unit.reference_count * sizeof(double));
            direction[knowns.list[i] + k] = 1.0;
            differentiate(instance, groups);
            double sum = 0.0;
            for (size_t j = 0, row = 0; j < unknowns.count; j++) {
                for (uint32_t n = 0; n < elements_of(unknowns, j); n++) {
                    sum += seed[row++] * sensitivity[unknowns.list[j] + n];
                }
            }
            result[column++] = sum;
        }
    }
    return status;
}
