/* The complex-step derivative: f(x + i h s) = f(x) + i h f'(x) s + O(h^2), with h so small that the
 * rest is below any rounding and no difference is taken (Squire & Trapp 1998, SIAM Review 40:110).
 * Included where ComplexValues, the table of variables and DIRECTIONAL are defined. */
#define COMPLEX_STEP 1e-100

static void load_complex(char *values, const double *by_reference, const double *seed)
{
    for (size_t i = 0; i < sizeof variables / sizeof *variables; i++) {
        const Variable *variable = &variables[i];
        char *place = values + variable->offset;
        for (uint32_t k = 0; is_field(variable) && k < variable->count; k++) {
            double value = by_reference[variable->reference + k];
            switch ((ValueType)variable->type) {
            case FLOAT64: {
                double *parts = (double *)(void *)place + 2 * k;
                parts[0] = value;
                parts[1] = seed[variable->reference + k] * COMPLEX_STEP;
                break;
            }
            case FLOAT32: ((float *)(void *)place)[k] = (float)value; break;
            case INT32: ((int32_t *)(void *)place)[k] = (int32_t)value; break;
            case UINT64: ((uint64_t *)(void *)place)[k] = (uint64_t)value; break;
            case ENUMERATION: ((int64_t *)(void *)place)[k] = (int64_t)value; break;
            case BOOLEAN: ((bool *)place)[k] = value != 0.0; break;
            case CLOCK:
            case BINARY:
            case VALUE_TYPES: break;
            }
        }
    }
}

void DIRECTIONAL(const double *by_reference, const void *workspace, bool initializing, uint32_t groups, const double *seed,
                 double *sensitivity);

void DIRECTIONAL(const double *by_reference, const void *workspace, bool initializing, uint32_t groups, const double *seed,
                 double *sensitivity)
{
    ComplexValues values;
    load_complex((char *)&values, by_reference, seed);
    if (initializing) {
        initialize(&values);
    }
    for (size_t group = 0; group < sizeof evaluate / sizeof *evaluate; group++) {
        if (groups & (1U << group)) {
            evaluate[group](&values, workspace);
        }
    }
    for (size_t i = 0; i < sizeof variables / sizeof *variables; i++) {
        const Variable *variable = &variables[i];
        const double *parts = (const double *)(const void *)((const char *)&values + variable->offset);
        for (uint32_t k = 0; variable->type == FLOAT64 && is_field(variable) && k < variable->count; k++) {
            sensitivity[variable->reference + k] = parts[2 * k + 1] / COMPLEX_STEP;
        }
    }
}
