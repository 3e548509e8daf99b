/* FMI 2.0.4, the tables of allowed calls in sections 3.2.3 and 4.2.4. */
#include "fmi2Functions.h"

#include "calls.h"

static int setup_experiment(Slave *slave)
{
    return (int)fmi2SetupExperiment(slave->instance, fmi2False, 0.0, 0.0, fmi2False, 0.0);
}

static int enter_initialization(Slave *slave)
{
    return (int)fmi2EnterInitializationMode(slave->instance);
}

static int enter_event_mode(Slave *slave)
{
    return (int)fmi2EnterEventMode(slave->instance);
}

static int new_discrete_states(Slave *slave)
{
    fmi2EventInfo info;
    return (int)fmi2NewDiscreteStates(slave->instance, &info);
}

static int enter_continuous_time(Slave *slave)
{
    return (int)fmi2EnterContinuousTimeMode(slave->instance);
}

static int get_nominals(Slave *slave)
{
    double nominals[MAX_STATES];
    return (int)fmi2GetNominalsOfContinuousStates(slave->instance, nominals, subject()->state_count);
}

static int set_debug_logging(Slave *slave)
{
    return (int)fmi2SetDebugLogging(slave->instance, fmi2False, 0, NULL);
}

enum { RUNNING = EVENT | CONTINUOUS_TIME | STEP };

const Call calls[] = {
    {"fmi2SetDebugLogging", set_debug_logging, ANY_KIND, ANY_MODE, 0},
    {"fmi2Reset", slave_reset, ANY_KIND, ANY_MODE, 0},
    {"fmi2SetupExperiment", setup_experiment, ANY_KIND, INSTANTIATED, ANY_MODE & ~INSTANTIATED},
    {"fmi2EnterInitializationMode", enter_initialization, ANY_KIND, INSTANTIATED, ANY_MODE & ~INSTANTIATED},
    {"fmi2ExitInitializationMode", slave_exit_initialization, ANY_KIND, INITIALIZATION, ANY_MODE & ~INITIALIZATION},
    {"fmi2Terminate", slave_terminate, ANY_KIND, RUNNING, ANY_MODE & ~RUNNING},
    {"fmi2EnterEventMode", enter_event_mode, ANY_KIND, CONTINUOUS_TIME, ANY_MODE & ~(EVENT | CONTINUOUS_TIME)},
    {"fmi2NewDiscreteStates", new_discrete_states, ANY_KIND, EVENT, ANY_MODE & ~EVENT},
    {"fmi2EnterContinuousTimeMode", enter_continuous_time, ANY_KIND, EVENT, ANY_MODE & ~(EVENT | CONTINUOUS_TIME)},
    {"fmi2CompletedIntegratorStep", slave_complete_step, ANY_KIND, CONTINUOUS_TIME, ANY_MODE & ~CONTINUOUS_TIME},
    {"fmi2SetTime", set_time, ANY_KIND, EVENT | CONTINUOUS_TIME, ANY_MODE & ~(EVENT | CONTINUOUS_TIME)},
    {"fmi2SetContinuousStates", set_states, ANY_KIND, CONTINUOUS_TIME, ANY_MODE & ~CONTINUOUS_TIME},
    {"fmi2GetContinuousStates", get_states, MODEL_EXCHANGE, EVENT | CONTINUOUS_TIME | TERMINATED, INSTANTIATED},
    {"fmi2GetDerivatives", get_derivatives, MODEL_EXCHANGE, EVENT | CONTINUOUS_TIME | TERMINATED, INSTANTIATED},
    {"fmi2GetNominalsOfContinuousStates", get_nominals, MODEL_EXCHANGE, EVENT | CONTINUOUS_TIME | TERMINATED, 0},
    {"fmi2DoStep", do_step, ANY_KIND, STEP, ANY_MODE & ~STEP},
    {"fmi2GetReal", get_output, ANY_KIND, INITIALIZATION | RUNNING | TERMINATED, INSTANTIATED},
    {"fmi2SetReal", set_input, ANY_KIND, INSTANTIATED | INITIALIZATION | RUNNING, TERMINATED},
    {"fmi2SetReal", set_fixed_parameter, ANY_KIND, INSTANTIATED | INITIALIZATION, RUNNING | TERMINATED},
};

const size_t call_count = sizeof calls / sizeof *calls;

void check_version_arguments(void)
{
    Slave slave;
    slave_open(&slave, CO_SIMULATION);
    slave_start(&slave);
    void *c = slave.instance;
    const Variable *input = pick(FLOAT64, INPUT, CONTINUOUS);
    fmi2ValueReference reference = input->reference;
    fmi2Integer first = 1, second = 2;
    double value = 0.0;
    void *state = NULL;
    size_t size;
    CHECK_REFUSED(&slave, (int)fmi2GetReal(c, NULL, 1, &value), "references NULL", "fmi2GetReal", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2GetReal(c, &reference, 1, NULL), "values NULL", "fmi2GetReal", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SetReal(c, &reference, 1, NULL), "values NULL", "fmi2SetReal", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2GetInteger(c, &reference, 1, NULL), "values NULL", "fmi2GetInteger", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SetInteger(c, &reference, 1, NULL), "values NULL", "fmi2SetInteger", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2GetBoolean(c, NULL, 1, &first), "references NULL", "fmi2GetBoolean", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SetBoolean(c, NULL, 1, &first), "references NULL", "fmi2SetBoolean", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2GetString(c, &reference, 1, NULL), "no such type", "fmi2GetString", "String");
    CHECK_REFUSED(&slave, (int)fmi2SetString(c, &reference, 1, NULL), "no such type", "fmi2SetString", "String");
    CHECK_REFUSED(&slave, (int)fmi2GetInteger(c, &reference, 1, &first), "wrong type", input->name, "Float64");
    CHECK_REFUSED(&slave, (int)fmi2SetBoolean(c, &reference, 1, &first), "wrong type", input->name, "Float64");
    CHECK_REFUSED(&slave, (int)fmi2GetFMUstate(c, NULL), "state NULL", "fmi2GetFMUstate", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SetFMUstate(c, NULL), "state NULL", "fmi2SetFMUstate", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SerializedFMUstateSize(c, NULL, &size), "state NULL", "fmi2SerializedFMUstateSize", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2DeSerializeFMUstate(c, NULL, 8, &state), "bytes NULL", "fmi2DeSerializeFMUstate", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2DeSerializeFMUstate(c, "", 1, NULL), "state NULL", "fmi2DeSerializeFMUstate", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SetRealInputDerivatives(c, &reference, 1, NULL, &value), "orders NULL",
                  "fmi2SetRealInputDerivatives", "NULL");
    CHECK_REFUSED(&slave, (int)fmi2SetRealInputDerivatives(c, &reference, 1, &second, &value), "order 2",
                  "fmi2SetRealInputDerivatives", input->name, "allowed");
    CHECK_REFUSED(&slave, (int)fmi2GetRealOutputDerivatives(c, &reference, 1, &first, &value), "not given",
                  "fmi2GetRealOutputDerivatives", "maxOutputDerivativeOrder");
    CHECK_REFUSED(&slave, (int)fmi2SetDebugLogging(c, fmi2True, 1, (fmi2String[]){"nonsense"}), "category", "nonsense",
                  "logStatusError");
    CHECK_REFUSED(&slave, (int)fmi2SetDebugLogging(c, fmi2True, 1, NULL), "categories NULL", "category");
    CHECK_REFUSED(&slave, (int)fmi2CancelStep(c), "nothing to cancel", "fmi2CancelStep");
    CHECK_REFUSED(&slave, (int)fmi2GetStatus(c, fmi2DoStepStatus, NULL), "no status", "fmi2GetStatus");
    CHECK_REFUSED(&slave, (int)fmi2GetRealStatus(c, fmi2LastSuccessfulTime, NULL), "value NULL", "fmi2GetRealStatus");
    for (size_t i = 0; i < subject()->variable_count; i++) {
        const Variable *variable = &subject()->variables[i];
        if (variable->group == STREAM) {
            CHECK_REFUSED(&slave, (int)fmi2GetReal(c, &variable->reference, 1, &value), "a stream", variable->name);
            CHECK_REFUSED(&slave, (int)fmi2GetInteger(c, &variable->reference, 1, &first), "a stream", variable->name);
        }
    }
    if (subject()->differentiable) {
        const Variable *output = pick(FLOAT64, OUTPUT, CONTINUOUS);
        CHECK_REFUSED(&slave, (int)fmi2GetDirectionalDerivative(c, &output->reference, 1, &reference, 1, NULL, &value),
                      "seed NULL", "fmi2GetDirectionalDerivative", "NULL");
        CHECK_REFUSED(&slave, (int)fmi2GetDirectionalDerivative(c, &output->reference, 1, &reference, 1, &value, NULL),
                      "result NULL", "fmi2GetDirectionalDerivative", "NULL");
        CHECK_REFUSED(&slave, (int)fmi2GetDirectionalDerivative(c, &reference, 1, &reference, 1, &value, &value),
                      "an input is no unknown", "fmi2GetDirectionalDerivative", input->name);
    }
    slave_close(&slave);
    CHECK(fmi2Instantiate("test", fmi2CoSimulation, subject()->token, NULL, NULL, fmi2False, fmi2False) == NULL,
          "without callbacks there is no instance");
    fmi2CallbackFunctions silent = {0};
    CHECK(fmi2Instantiate("test", fmi2CoSimulation, "wrong", NULL, &silent, fmi2False, fmi2False) == NULL,
          "without a logger a wrong token is refused in silence");
    CHECK(fmi2Instantiate("test", (fmi2Type)7, subject()->token, NULL, &silent, fmi2False, fmi2False) == NULL,
          "there is no kind 7");
}
