/* Saved states: what is restored goes on to the bit; what is damaged or foreign is refused, and said. */
#include "check.h"
#include "run.h"
#include "tests.h"

#include <stdlib.h>
#include <string.h>

enum { STEPS = 20 };

static void check_restore(Kind kind)
{
    Slave slave, other;
    void *state = NULL, *again = NULL;
    slave_open(&slave, kind);
    slave_start(&slave);
    Run run = run_from(&slave, 0.0, 1);
    for (int i = 0; i < STEPS; i++) {
        run_step(&run);
    }
    double time = run.time;
    CHECK(slave_save(&slave, &state) == OK, "%s", slave.log.text);
    uint64_t digest = run_steps(&slave, time, 2, STEPS);
    CHECK(slave_save(&slave, &again) == OK, "%s", slave.log.text);
    CHECK(slave_restore(&slave, state) == OK, "%s", slave.log.text);
    CHECK(run_steps(&slave, time, 2, STEPS) == digest, "kind %d: a restored instance gives other bits", (int)kind);
    slave_terminate(&slave);
    CHECK(slave_restore(&slave, state) == OK, "%s", slave.log.text);
    CHECK(run_steps(&slave, time, 2, STEPS) == digest, "kind %d: the mode is restored too", (int)kind);
    slave_reset(&slave);
    CHECK(slave_restore(&slave, state) == OK, "%s", slave.log.text);
    CHECK(run_steps(&slave, time, 2, STEPS) == digest, "kind %d: a state outlives a reset", (int)kind);

    slave_open(&other, kind);
    CHECK(slave_restore(&other, state) == OK, "%s", other.log.text);
    CHECK(run_steps(&other, time, 2, STEPS) == digest, "kind %d: another instance takes the state", (int)kind);
    CHECK(slave_save(&other, &again) == OK, "a state is written over: %s", other.log.text);
    slave_close(&slave);
    CHECK(slave_restore(&other, again) == OK, "a state outlives its instance: %s", other.log.text);
    CHECK(slave_release(&other, &state) == OK && !state, "a released state is NULL");
    slave_release(&other, &again);
    slave_close(&other);
}

static char *serialized(Slave *slave, size_t *size)
{
    void *state = NULL;
    CHECK(slave_save(slave, &state) == OK && slave_serialized_size(slave, state, size) == OK, "%s", slave->log.text);
    char *bytes = malloc(*size);
    CHECK(slave_serialize(slave, state, bytes, *size) == OK, "%s", slave->log.text);
    CHECK_REFUSED(slave, slave_serialize(slave, state, bytes, *size - 1), "too small an array", "bytes", "needed");
    slave_release(slave, &state);
    return bytes;
}

/* As long as said and no longer: the sanitizer sees a byte read too far. */
static void check_damaged(Slave *slave, const char *bytes, size_t size)
{
    void *state = NULL;
    for (size_t length = 0; length < size; length++) {
        char *part = malloc(length + 1);
        memcpy(part, bytes, length);
        CHECK_REFUSED(slave, slave_deserialize(slave, part, length, &state), "truncated", "bytes", "needed");
        free(part);
    }
    char *copy = malloc(size + 1);
    memcpy(copy, bytes, size);
    copy[size] = 0;
    CHECK_REFUSED(slave, slave_deserialize(slave, copy, size + 1, &state), "too long", "bytes", "needed");
    for (size_t i = 0; i < size; i++) {
        for (int flip = 1; flip < 256; flip = flip * 4 + 3) {
            copy[i] = (char)(bytes[i] ^ flip);
            CHECK_REFUSED(slave, slave_deserialize(slave, copy, size, &state), "a wrong byte", "the state is refused");
        }
        copy[i] = bytes[i];
    }
    CHECK(!state, "no state comes of a refusal");
    CHECK(slave_deserialize(slave, copy, size, &state) == OK, "whole again: %s", slave->log.text);
    slave_release(slave, &state);
    free(copy);
}

static void check_serialized(Kind kind)
{
    Slave slave, other;
    void *state = NULL;
    size_t size, size_again;
    slave_open(&slave, kind);
    slave_start(&slave);
    run_steps(&slave, 0.0, 1, 1);
    Run run = run_from(&slave, 0.0, 1);
    slave_reset(&slave);
    slave_start(&slave);
    for (int i = 0; i < STEPS; i++) {
        run_step(&run);
    }
    char *bytes = serialized(&slave, &size), *again = serialized(&slave, &size_again);
    CHECK(size == size_again && memcmp(bytes, again, size) == 0, "kind %d: the same state gives the same bytes", (int)kind);
    free(again);
    uint64_t digest = run_steps(&slave, run.time, 2, STEPS);
    slave_close(&slave);

    slave_open(&other, kind);
    CHECK(slave_deserialize(&other, bytes, size, &state) == OK, "%s", other.log.text);
    CHECK(slave_restore(&other, state) == OK, "%s", other.log.text);
    CHECK(run_steps(&other, run.time, 2, STEPS) == digest, "kind %d: bytes give other bits back", (int)kind);
    slave_release(&other, &state);
    check_damaged(&other, bytes, size);
    CHECK(slave_reset(&other) == OK && run_life(&other, 1, 5) == run_new(kind, 1, 5), "not usable after refusals");
    slave_close(&other);
    free(bytes);
}

static void check_other_kind(void)
{
    Slave master, slave;
    void *state = NULL;
    size_t size;
    slave_open(&master, MODEL_EXCHANGE);
    slave_open(&slave, CO_SIMULATION);
    slave_start(&master);
    char *bytes = serialized(&master, &size);
    CHECK_REFUSED(&slave, slave_deserialize(&slave, bytes, size, &state), "model exchange", "the state is refused", "kind");
    CHECK(slave_save(&master, &state) == OK, "%s", master.log.text);
    CHECK_REFUSED(&slave, slave_restore(&slave, state), "model exchange", "the state is refused", "kind");
    slave_release(&master, &state);
    slave_close(&master);
    slave_close(&slave);
    free(bytes);
}

void test_states(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (slave_kinds() & kind) {
            check_restore((Kind)kind);
            check_serialized((Kind)kind);
        }
    }
    if (slave_kinds() & MODEL_EXCHANGE) {
        check_other_kind();
    }
}
