/* FMI 3.0.2, the lists of allowed calls of each state in sections 2.3, 3.2 and 4.2. */
#include "fmi3Functions.h"

#include "calls.h"

#include <math.h>

static int enter_initialization(Slave *slave)
{
    return slave_enter_initialization(slave, 0.0, NULL);
}

static int enter_event_mode(Slave *slave)
{
    return (int)fmi3EnterEventMode(slave->instance);
}

static int enter_step_mode(Slave *slave)
{
    return (int)fmi3EnterStepMode(slave->instance);
}

static int enter_continuous_time(Slave *slave)
{
    return (int)fmi3EnterContinuousTimeMode(slave->instance);
}

static int evaluate_discrete_states(Slave *slave)
{
    return (int)fmi3EvaluateDiscreteStates(slave->instance);
}

static int update_discrete_states(Slave *slave)
{
    fmi3Boolean flags[5];
    fmi3Float64 next;
    return (int)fmi3UpdateDiscreteStates(slave->instance, &flags[0], &flags[1], &flags[2], &flags[3], &flags[4], &next);
}

static int get_nominals(Slave *slave)
{
    double nominals[MAX_STATES];
    return (int)fmi3GetNominalsOfContinuousStates(slave->instance, nominals, subject()->state_count);
}

/* Of a unit without clocks: of none. */
static int get_clock(Slave *slave)
{
    const Variable *clock = pick(CLOCK, INPUT, -1);
    fmi3Clock value;
    return (int)fmi3GetClock(slave->instance, clock ? &clock->reference : NULL, clock != NULL, &value);
}

static int set_clock(Slave *slave)
{
    const Variable *clock = pick(CLOCK, INPUT, -1);
    return (int)fmi3SetClock(slave->instance, clock ? &clock->reference : NULL, clock != NULL, (fmi3Clock[]){false});
}

static const Variable *countdown(void)
{
    const Subject *unit = subject();
    for (size_t i = 0; i < unit->variable_count; i++) {
        if (unit->variables[i].countdown) {
            return &unit->variables[i];
        }
    }
    return NULL;
}

static int get_interval(Slave *slave)
{
    const Variable *clock = countdown();
    double interval;
    fmi3IntervalQualifier qualifier;
    return (int)fmi3GetIntervalDecimal(slave->instance, clock ? &clock->reference : NULL, clock != NULL, &interval,
                                       &qualifier);
}

static int get_interval_fraction(Slave *slave)
{
    const Variable *clock = countdown();
    fmi3UInt64 counter, resolution;
    fmi3IntervalQualifier qualifier;
    return (int)fmi3GetIntervalFraction(slave->instance, clock ? &clock->reference : NULL, clock != NULL, &counter,
                                        &resolution, &qualifier);
}

static int set_debug_logging(Slave *slave)
{
    return (int)fmi3SetDebugLogging(slave->instance, false, 0, NULL);
}

enum {
    BOTH_CO_SIMULATIONS = CO_SIMULATION | CO_SIMULATION_WITH_EVENT_MODE,
    RUNNING = EVENT | CONTINUOUS_TIME | STEP,
    READABLE = INITIALIZATION | RUNNING | TERMINATED,
};

const Call calls[] = {
    {"fmi3SetDebugLogging", set_debug_logging, ANY_KIND, ANY_MODE, 0},
    {"fmi3Reset", slave_reset, ANY_KIND, ANY_MODE, 0},
    {"fmi3EnterConfigurationMode", slave_enter_configuration, ANY_KIND, INSTANTIATED, ANY_MODE & ~INSTANTIATED},
    {"fmi3ExitConfigurationMode", slave_exit_configuration, ANY_KIND, CONFIGURATION, ANY_MODE & ~CONFIGURATION},
    {"fmi3EnterInitializationMode", enter_initialization, ANY_KIND, INSTANTIATED, ANY_MODE & ~INSTANTIATED},
    {"fmi3ExitInitializationMode", slave_exit_initialization, ANY_KIND, INITIALIZATION, ANY_MODE & ~INITIALIZATION},
    {"fmi3Terminate", slave_terminate, ANY_KIND, RUNNING, ANY_MODE & ~RUNNING},
    {"fmi3EnterEventMode", enter_event_mode, MODEL_EXCHANGE, CONTINUOUS_TIME, ANY_MODE & ~CONTINUOUS_TIME},
    {"fmi3EnterEventMode", enter_event_mode, CO_SIMULATION_WITH_EVENT_MODE, STEP, ANY_MODE & ~STEP},
    {"fmi3EnterEventMode", enter_event_mode, CO_SIMULATION, 0, STEP},
    {"fmi3EnterStepMode", enter_step_mode, CO_SIMULATION_WITH_EVENT_MODE, EVENT, ANY_MODE & ~EVENT},
    {"fmi3EnterStepMode", enter_step_mode, MODEL_EXCHANGE, 0, EVENT},
    {"fmi3EnterContinuousTimeMode", enter_continuous_time, MODEL_EXCHANGE, EVENT, ANY_MODE & ~EVENT},
    {"fmi3EnterContinuousTimeMode", enter_continuous_time, BOTH_CO_SIMULATIONS, 0, EVENT | STEP},
    {"fmi3EvaluateDiscreteStates", evaluate_discrete_states, ANY_KIND, INITIALIZATION | EVENT,
     ANY_MODE & ~(INITIALIZATION | EVENT)},
    {"fmi3UpdateDiscreteStates", update_discrete_states, ANY_KIND, EVENT, ANY_MODE & ~EVENT},
    {"fmi3CompletedIntegratorStep", slave_complete_step, ANY_KIND, CONTINUOUS_TIME, ANY_MODE & ~CONTINUOUS_TIME},
    {"fmi3SetTime", set_time, MODEL_EXCHANGE, CONTINUOUS_TIME, ANY_MODE & ~(EVENT | CONTINUOUS_TIME)},
    {"fmi3SetTime", set_time, BOTH_CO_SIMULATIONS, 0, ANY_MODE},
    {"fmi3SetContinuousStates", set_states, ANY_KIND, CONTINUOUS_TIME, ANY_MODE & ~CONTINUOUS_TIME},
    {"fmi3GetContinuousStates", get_states, MODEL_EXCHANGE, READABLE, INSTANTIATED | CONFIGURATION},
    {"fmi3GetContinuousStateDerivatives", get_derivatives, MODEL_EXCHANGE, READABLE, INSTANTIATED | CONFIGURATION},
    {"fmi3GetNominalsOfContinuousStates", get_nominals, MODEL_EXCHANGE, READABLE, INSTANTIATED | CONFIGURATION},
    {"fmi3GetClock", get_clock, ANY_KIND, EVENT, ANY_MODE & ~EVENT},
    {"fmi3SetClock", set_clock, ANY_KIND, EVENT, ANY_MODE & ~EVENT},
    {"fmi3GetIntervalDecimal", get_interval, ANY_KIND, INITIALIZATION | EVENT, ANY_MODE & ~(INITIALIZATION | EVENT)},
    {"fmi3GetIntervalFraction", get_interval_fraction, ANY_KIND, INITIALIZATION | EVENT,
     ANY_MODE & ~(INITIALIZATION | EVENT)},
    {"fmi3DoStep", do_step, ANY_KIND, STEP, ANY_MODE & ~STEP},
    {"fmi3GetFloat64", get_output, ANY_KIND, READABLE, INSTANTIATED | CONFIGURATION},
    {"fmi3SetFloat64", set_input, ANY_KIND, INSTANTIATED | INITIALIZATION | RUNNING, CONFIGURATION | TERMINATED},
    {"fmi3SetFloat64", set_fixed_parameter, ANY_KIND, INSTANTIATED | INITIALIZATION, CONFIGURATION | RUNNING | TERMINATED},
};

const size_t call_count = sizeof calls / sizeof *calls;

static void check_sizes(Slave *slave, const Variable *input)
{
    double values[MAX_ELEMENTS + 1] = {0};
    uint32_t reference = input->reference;
    CHECK_REFUSED(slave, (int)fmi3SetFloat64(slave->instance, &reference, 1, values, input->count - 1), "one value short",
                  "fmi3SetFloat64", input->name);
    CHECK_REFUSED(slave, (int)fmi3GetFloat64(slave->instance, &reference, 1, values, input->count - 1), "one value short",
                  "fmi3GetFloat64", input->name);
    CHECK_REFUSED(slave, (int)fmi3SetFloat64(slave->instance, &reference, 1, values, input->count + 1), "one value over",
                  "fmi3SetFloat64", "1 values more");
    CHECK_REFUSED(slave, (int)fmi3GetFloat64(slave->instance, &reference, 1, values, input->count + 1), "one value over",
                  "fmi3GetFloat64", "1 values more");
    if (input->count > 1) {
        reference++;
        CHECK_REFUSED(slave, (int)fmi3GetFloat64(slave->instance, &reference, 1, values, 1), "inside an array",
                      "fmi3GetFloat64", "unknown value reference");
    }
}

static void check_types(Slave *slave, const Variable *input)
{
    uint32_t reference = input->reference;
    void *c = slave->instance;
    union {
        double float64[MAX_ELEMENTS];
        int32_t int32[MAX_ELEMENTS];
    } values = {{0}};
    CHECK_REFUSED(slave, (int)fmi3GetInt32(c, &reference, 1, values.int32, input->count), "wrong type", "fmi3GetInt32",
                  input->name, "Float64");
    CHECK_REFUSED(slave, (int)fmi3SetInt32(c, &reference, 1, values.int32, input->count), "wrong type", "fmi3SetInt32",
                  input->name, "Float64");
}

/* Types of which no unit has a variable, and clocks: exported, refused, said. */
#define CHECK_NO_TYPE(TYPE)                                                                                            \
    do {                                                                                                               \
        fmi3##TYPE values[1] = {0};                                                                                    \
        CHECK_REFUSED(slave, (int)fmi3Get##TYPE(c, &reference, 1, values, 1), "no such type", "fmi3Get" #TYPE);         \
        CHECK_REFUSED(slave, (int)fmi3Set##TYPE(c, &reference, 1, values, 1), "no such type", "fmi3Set" #TYPE);         \
    } while (0)

static void check_what_no_unit_has(Slave *slave, uint32_t reference)
{
    void *c = slave->instance;
    double time = 0.0;
    fmi3UInt64 counter = 0, resolution = 1;
    fmi3Clock clock = false;
    size_t size = 0;
    fmi3Binary binary = NULL;
    fmi3IntervalQualifier qualifier = fmi3IntervalNotYetKnown;
    CHECK_NO_TYPE(Int8);
    CHECK_NO_TYPE(UInt8);
    CHECK_NO_TYPE(Int16);
    CHECK_NO_TYPE(UInt16);
    CHECK_NO_TYPE(UInt32);
    CHECK_NO_TYPE(String);
    CHECK_REFUSED(slave, (int)fmi3GetBinary(c, &reference, 1, &size, &binary, 1), "no such type", "fmi3GetBinary");
    CHECK_REFUSED(slave, (int)fmi3SetBinary(c, &reference, 1, &size, &binary, 1), "no such type", "fmi3SetBinary");
    CHECK_REFUSED(slave, (int)fmi3GetClock(c, &reference, 1, &clock), "no clocks", "fmi3GetClock");
    CHECK_REFUSED(slave, (int)fmi3SetClock(c, &reference, 1, &clock), "no clocks", "fmi3SetClock");
    CHECK_REFUSED(slave, (int)fmi3GetIntervalDecimal(c, &reference, 1, &time, &qualifier), "no clocks", "fmi3GetInterval");
    CHECK_REFUSED(slave, (int)fmi3GetIntervalFraction(c, &reference, 1, &counter, &resolution, &qualifier), "no clocks",
                  "fmi3GetIntervalFraction");
    CHECK_REFUSED(slave, (int)fmi3GetShiftDecimal(c, &reference, 1, &time), "no clocks", "fmi3GetShiftDecimal");
    CHECK_REFUSED(slave, (int)fmi3GetShiftFraction(c, &reference, 1, &counter, &resolution), "no clocks", "fmi3GetShift");
    CHECK_REFUSED(slave, (int)fmi3SetIntervalDecimal(c, &reference, 1, &time), "no clocks", "fmi3SetIntervalDecimal");
    CHECK_REFUSED(slave, (int)fmi3SetIntervalFraction(c, &reference, 1, &counter, &resolution), "no clocks",
                  "fmi3SetIntervalFraction");
    CHECK_REFUSED(slave, (int)fmi3SetShiftDecimal(c, &reference, 1, &time), "no clocks", "fmi3SetShiftDecimal");
    CHECK_REFUSED(slave, (int)fmi3SetShiftFraction(c, &reference, 1, &counter, &resolution), "no clocks", "fmi3SetShift");
    CHECK_REFUSED(slave, (int)fmi3ActivateModelPartition(c, reference, 0.0), "no clocks", "fmi3ActivateModelPartition");
    CHECK_REFUSED(slave, (int)fmi3GetVariableDependencies(c, reference, NULL, NULL, NULL, NULL, 0), "not dynamic",
                  "fmi3GetVariableDependencies");
    CHECK_REFUSED(slave, (int)fmi3GetEventIndicators(c, &time, 1), "no event indicators", "fmi3GetEventIndicators");
    CHECK(fmi3GetNumberOfEventIndicators(c, &size) == fmi3OK && size == 0, "no event indicators");
}

static void check_null(Slave *slave, const Variable *input)
{
    void *c = slave->instance;
    uint32_t reference = input->reference;
    double values[MAX_ELEMENTS] = {0};
    void *state = NULL;
    size_t size;
    CHECK_REFUSED(slave, (int)fmi3GetFloat64(c, NULL, 1, values, 1), "references NULL", "fmi3GetFloat64", "NULL");
    CHECK_REFUSED(slave, (int)fmi3GetFloat64(c, &reference, 1, NULL, 1), "values NULL", "fmi3GetFloat64", "NULL");
    CHECK_REFUSED(slave, (int)fmi3SetFloat64(c, &reference, 1, NULL, 1), "values NULL", "fmi3SetFloat64", "NULL");
    CHECK_REFUSED(slave, (int)fmi3SetBoolean(c, NULL, 1, NULL, 1), "all NULL", "fmi3SetBoolean", "NULL");
    CHECK_REFUSED(slave, (int)fmi3GetFMUState(c, NULL), "state NULL", "fmi3GetFMUState", "NULL");
    CHECK_REFUSED(slave, (int)fmi3SetFMUState(c, NULL), "state NULL", "fmi3SetFMUState", "NULL");
    CHECK_REFUSED(slave, (int)fmi3SerializedFMUStateSize(c, NULL, &size), "state NULL", "fmi3SerializedFMUStateSize", "NULL");
    CHECK_REFUSED(slave, (int)fmi3SerializeFMUState(c, NULL, NULL, 8), "state NULL", "fmi3SerializeFMUState", "NULL");
    CHECK_REFUSED(slave, (int)fmi3DeserializeFMUState(c, NULL, 8, &state), "bytes NULL", "fmi3DeserializeFMUState", "NULL");
    CHECK_REFUSED(slave, (int)fmi3DeserializeFMUState(c, (const fmi3Byte *)"", 1, NULL), "state NULL",
                  "fmi3DeserializeFMUState", "NULL");
    CHECK_REFUSED(slave, (int)fmi3SetDebugLogging(c, true, 1, (fmi3String[]){"nonsense"}), "category", "nonsense",
                  "logStatusError");
    CHECK_REFUSED(slave, (int)fmi3SetDebugLogging(c, true, 1, NULL), "categories NULL", "category");
    CHECK_REFUSED(slave, (int)fmi3GetNumberOfContinuousStates(c, NULL), "count NULL", "fmi3GetNumberOfContinuousStates");
    CHECK_REFUSED(slave, (int)fmi3GetNumberOfVariableDependencies(c, reference, NULL), "count NULL",
                  "fmi3GetNumberOfVariableDependencies");
    CHECK_REFUSED(slave, (int)fmi3GetOutputDerivatives(c, &reference, 1, NULL, NULL, 1), "not given",
                  "fmi3GetOutputDerivatives");
    CHECK(fmi3DoStep(c, 0.0, 0.01, true, NULL, NULL, NULL, NULL) == fmi3OK, "results that nobody wants: %s", slave->log.text);
}

/* The sum of all elements of the Jacobian, both ways: equal up to the rounding of a sum. Returns the sum of their sizes. */
static double check_adjoint(Slave *slave, const Variable *output, const Variable *input)
{
    double ones[MAX_ELEMENTS], result[MAX_ELEMENTS], size = 0.0, difference = 0.0;
    for (size_t i = 0; i < MAX_ELEMENTS; i++) {
        ones[i] = 1.0;
    }
    CHECK(slave_directional(slave, output, input, result) == OK, "%s", slave->log.text);
    for (uint32_t i = 0; i < output->count; i++) {
        difference += result[i];
        size += fabs(result[i]);
    }
    CHECK(fmi3GetAdjointDerivative(slave->instance, &output->reference, 1, &input->reference, 1, ones, output->count, result,
                                   input->count) == fmi3OK, "%s", slave->log.text);
    for (uint32_t i = 0; i < input->count; i++) {
        difference -= result[i];
        size += fabs(result[i]);
    }
    CHECK(fabs(difference) <= 1e-15 * (output->count + input->count) * size, "off by %g", difference);
    return size;
}

static void check_adjoints(Slave *slave, const Variable *input)
{
    double size = 0.0;
    for (size_t i = 0; i < subject()->variable_count; i++) {
        const Variable *output = &subject()->variables[i];
        if (output->causality == OUTPUT && output->type == FLOAT64) {
            size += check_adjoint(slave, output, input);
        }
    }
    CHECK(size > 0.0, "no output depends on %s", input->name);
}

static void check_derivative_arguments(Slave *slave, const Variable *input)
{
    void *c = slave->instance;
    const Variable *output = pick(FLOAT64, OUTPUT, CONTINUOUS);
    const uint32_t *y = &output->reference, *u = &input->reference;
    double values[MAX_ELEMENTS] = {0}, result[MAX_ELEMENTS + 1];
    CHECK_REFUSED(slave, (int)fmi3GetDirectionalDerivative(c, y, 1, u, 1, NULL, input->count, result, output->count),
                  "seed NULL", "fmi3GetDirectionalDerivative", "NULL");
    CHECK_REFUSED(slave, (int)fmi3GetAdjointDerivative(c, y, 1, u, 1, values, output->count, NULL, input->count),
                  "result NULL", "fmi3GetAdjointDerivative", "NULL");
    CHECK_REFUSED(slave, (int)fmi3GetDirectionalDerivative(c, NULL, 1, u, 1, values, input->count, result, output->count),
                  "unknowns NULL", "fmi3GetDirectionalDerivative", "NULL");
    CHECK_REFUSED(slave, (int)fmi3GetAdjointDerivative(c, y, 1, NULL, 1, values, output->count, result, input->count),
                  "knowns NULL", "fmi3GetAdjointDerivative", "NULL");
    CHECK_REFUSED(slave, (int)fmi3GetDirectionalDerivative(c, y, 1, u, 1, values, input->count, result, output->count + 1),
                  "too long a result", "fmi3GetDirectionalDerivative", "elements");
    CHECK_REFUSED(slave, (int)fmi3GetAdjointDerivative(c, y, 1, u, 1, values, output->count + 1, result, input->count),
                  "too long a seed", "fmi3GetAdjointDerivative", "elements");
    CHECK_REFUSED(slave, (int)fmi3GetDirectionalDerivative(c, u, 1, u, 1, values, input->count, result, input->count),
                  "an input is no unknown", "fmi3GetDirectionalDerivative", input->name);
}

static void receive(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    record_line(environment, (int)status, category, message);
}

void check_version_arguments(void)
{
    Slave slave;
    slave_open(&slave, CO_SIMULATION);
    slave_start(&slave);
    const Variable *input = pick(FLOAT64, INPUT, CONTINUOUS);
    check_sizes(&slave, input);
    check_types(&slave, input);
    check_what_no_unit_has(&slave, input->reference);
    check_null(&slave, input);
    if (subject()->differentiable) {
        check_adjoints(&slave, input);
        check_derivative_arguments(&slave, input);
    }
    slave_close(&slave);
    CHECK(fmi3InstantiateCoSimulation("test", "wrong", NULL, false, true, false, false, NULL, 0, NULL, NULL, NULL) == NULL,
          "without a logger a wrong token is refused in silence");
    LogRecord log = {0};
    CHECK(fmi3InstantiateScheduledExecution("test", subject()->token, NULL, false, true, &log, receive, NULL, NULL,
                                            NULL) == NULL && log.lines == 1, "scheduled execution is refused, and said");
}
