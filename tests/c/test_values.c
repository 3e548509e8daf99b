/* Bad values, of every variable: refused with a line that names it and what is allowed, nothing set. */
#include "check.h"
#include "run.h"
#include "tests.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool is_settable(const Variable *variable, Mode mode)
{
    if (!is_readable(variable)) {
        return false;
    }
    return variable->causality == INPUT || (variable->causality == PARAMETER && mode == INITIALIZATION) ||
           (variable->causality == STRUCTURAL_PARAMETER && mode == CONFIGURATION);
}

/* What may not be set: how many values were written. */
static size_t bad_values(const Variable *variable, double *bad)
{
    size_t count = 0;
    bool real = variable->type == FLOAT64 || variable->type == FLOAT32;
    if (real) {
        bad[count++] = NAN;
        bad[count++] = INFINITY;
        bad[count++] = -INFINITY;
    }
    if (isfinite(variable->minimum) && variable->type != BOOLEAN) {
        double step = real ? 1e-9 * (1.0 + fabs(variable->minimum)) : 1.0;
        if (variable->type != UINT64 || variable->minimum > 0.0) {
            bad[count++] = variable->minimum - step;
        }
    }
    if (isfinite(variable->maximum) && variable->type != BOOLEAN) {
        bad[count++] = variable->maximum + (real ? 1e-9 * (1.0 + fabs(variable->maximum)) : 1.0);
    }
    if (variable->type == ENUMERATION) {
        bad[count++] = 2147483647.0;
        bad[count++] = -2147483648.0;
    }
    return count;
}

static void check_bad_values(Slave *slave, const Variable *variable)
{
    double bad[8], before[MAX_ELEMENTS], after[MAX_ELEMENTS], values[MAX_ELEMENTS];
    size_t count = bad_values(variable, bad);
    CHECK(slave_get(slave, variable, before) == OK, "%s", slave->log.text);
    for (size_t i = 0; i < count; i++) {
        for (uint32_t k = 0; k < variable->count; k++) {
            char name[128];
            snprintf(name, sizeof name, variable->count > 1 || variable->size_of ? "%s[%u]" : "%s", variable->name, (unsigned)k + 1);
            memcpy(values, before, sizeof values);
            values[k] = bad[i];
            CHECK_REFUSED(slave, slave_set(slave, variable, values), name, name, "allowed range");
            CHECK(slave_get(slave, variable, after) == OK, "%s", slave->log.text);
            CHECK(after[k] == before[k], "%s: %g was set", name, bad[i]);
        }
    }
}

static void check_mode(Kind kind, Mode mode, uint64_t digest)
{
    Slave slave;
    slave_open(&slave, kind);
    if (slave_reach(&slave, mode)) {
        for (size_t i = 0; i < subject()->variable_count; i++) {
            const Variable *variable = &subject()->variables[i];
            if (is_settable(variable, mode)) {
                check_bad_values(&slave, variable);
            } else if (is_readable(variable) && variable->causality == OUTPUT && mode != CONFIGURATION) {
                double values[MAX_ELEMENTS] = {0};
                CHECK_REFUSED(&slave, slave_set(&slave, variable, values), "an output is set", variable->name);
            }
        }
        CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 5) == digest, "mode %d: not usable after reset", (int)mode);
    }
    slave_close(&slave);
}

/* Each element may be right and the four not: said at the first use. */
static void check_zero_quaternions(Kind kind, uint64_t digest)
{
    static const double wrong[][4] = {{0.0}, {0.1, 0.1, 0.1, 0.1}, {3.0, 0.0, 0.0, 0.0}, {1e200, 1e200, 0.0, 0.0}};
    for (size_t i = 0; i < subject()->variable_count; i++) {
        const Variable *variable = &subject()->variables[i];
        for (size_t w = 0; variable->quaternion && is_settable(variable, INITIALIZATION) && w < 4; w++) {
            Slave slave;
            slave_open(&slave, kind);
            slave_enter_initialization(&slave, 0.0, NULL);
            int status = slave_set(&slave, variable, wrong[w]);
            if (status == OK) {
                status = slave_exit_initialization(&slave);
            }
            CHECK_REFUSED(&slave, status, "a quaternion of wrong norm", variable->name, "allowed range");
            CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 5) == digest, "%s: not usable after reset", variable->name);
            if (variable->causality == INPUT && kind != MODEL_EXCHANGE) {
                slave_reset(&slave);
                slave_start(&slave);
                status = slave_set(&slave, variable, wrong[w]);
                status = status == OK ? slave_step(&slave, 0.0, 0.01) : status;
                CHECK_REFUSED(&slave, status, "a quaternion of wrong norm", variable->name, "allowed range");
                status = slave_set(&slave, variable, (double[]){1.0, 0.0, 0.0, 0.0});
                CHECK(status == OK && slave_step(&slave, 0.0, 0.01) == OK, "%s set right: %s", variable->name, slave.log.text);
            }
            slave_close(&slave);
        }
    }
}

static void check_unknown_references(Kind kind)
{
    Slave slave;
    slave_open(&slave, kind);
    slave_start(&slave);
    Variable unknown = subject()->variables[0];
    unknown.count = 1;
    for (int type = FLOAT64; type < VALUE_TYPES; type++) {
        const uint32_t references[] = {(uint32_t)subject()->reference_count, 70000, UINT32_MAX};
        for (size_t i = 0; type != FLOAT32 && type != CLOCK && i < 3; i++) {
            double value = 0.0;
            unknown.type = (uint8_t)type;
            unknown.reference = references[i];
            CHECK_REFUSED(&slave, slave_get(&slave, &unknown, &value), "get", "unknown value reference", "allowed range");
            CHECK_REFUSED(&slave, slave_set(&slave, &unknown, &value), "set", "unknown value reference", "allowed range");
        }
    }
    for (size_t i = 0; i < subject()->variable_count; i++) {
        const Variable *variable = &subject()->variables[i];
        if (variable->causality == MEMORY) {
            double values[MAX_ELEMENTS] = {0};
            CHECK_REFUSED(&slave, slave_get(&slave, variable, values), variable->name, "unknown value reference");
            CHECK_REFUSED(&slave, slave_set(&slave, variable, values), variable->name, "unknown value reference");
        }
    }
    slave_close(&slave);
}

/* What no limit of a single variable can say. */
static void check_combinations(Kind kind, uint64_t digest)
{
    static const struct {
        const char *unit, *variable;
        double values[6];
    } wrong[] = {
        {"RigidBody", "inertia", {1.0, 1.0, 3.0}},      {"HingedBody", "inertia", {1.0, 1.0, 3.0}},
        {"HingedBody", "axis", {0.0, 0.0, 0.0}},        {"HingedBody", "axis", {2.0, 0.0, 0.0}},
        {"CompliantJoint", "axis", {0.0, 0.0, 0.0}},    {"CompliantJoint", "axis", {0.0, -1.0, 1e-4}},
        {"ArmSkin", "radius", {5.0}},                   {"ArmSkin", "blend_half_width", {5.0}},
        {"UltrasonicSensor", "period", {1e-6}},         {"UltrasonicSensor", "minimum_range", {50.0}},
        {"UltrasonicSensor", "velocity", {400.0, 0, 0}}, {"UltrasonicSensor", "surface_triangles", {0.0, 1.0}},
    };
    for (size_t w = 0; w < sizeof wrong / sizeof *wrong; w++) {
        for (size_t i = 0; i < subject()->variable_count; i++) {
            const Variable *variable = &subject()->variables[i];
            if (strcmp(wrong[w].unit, subject()->name) == 0 && strcmp(wrong[w].variable, variable->name) == 0 &&
                slave_has(variable)) {
                Slave slave;
                slave_open(&slave, kind);
                slave_enter_initialization(&slave, 0.0, NULL);
                CHECK(slave_set(&slave, variable, wrong[w].values) == OK, "%s", slave.log.text);
                CHECK_REFUSED(&slave, slave_exit_initialization(&slave), variable->name, variable->name, "allowed range");
                CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 5) == digest, "not usable after reset");
                slave_close(&slave);
            }
        }
    }
}

void test_values(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (slave_kinds() & kind) {
            uint64_t digest = run_new((Kind)kind, 1, 5);
            check_mode((Kind)kind, INITIALIZATION, digest);
            check_mode((Kind)kind, STEP, digest);
            check_zero_quaternions((Kind)kind, digest);
            check_unknown_references((Kind)kind);
            check_combinations((Kind)kind, digest);
        }
    }
}
