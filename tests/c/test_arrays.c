/* Arrays that a structural parameter sizes: as long as it says, part of the state, and never too short. */
#include "allocations.h"
#include "check.h"
#include "pick.h"
#include "run.h"
#include "tests.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXTENT = 5 };

/* An input that is such an array; NULL for none, as in FMI 2. */
static const Variable *sized_input(size_t n)
{
    const Subject *unit = subject();
    for (size_t i = 0; i < unit->variable_count; i++) {
        const Variable *variable = &unit->variables[i];
        if (variable->causality == INPUT && variable->size_of && slave_has(variable) && n-- == 0) {
            return variable;
        }
    }
    return NULL;
}

/* The same, as long as it is when the structural parameter has a value. */
static Variable of_extent(const Variable *variable, size_t extent)
{
    Variable whole = *variable;
    whole.count = (uint32_t)(variable->count * extent);
    return whole;
}

static void set_extent(Slave *slave, double extent)
{
    CHECK(slave_enter_configuration(slave) == OK, "%s", slave->log.text);
    CHECK(slave_set(slave, pick(UINT64, STRUCTURAL_PARAMETER, -1), &extent) == OK, "%s", slave->log.text);
    CHECK(slave_exit_configuration(slave) == OK, "%s", slave->log.text);
}

/* Whole numbers that are allowed as indices too. */
static void fill(const Variable *whole, size_t extent, size_t shift, double *values)
{
    for (uint32_t k = 0; k < whole->count; k++) {
        values[k] = (double)((k + shift) % extent);
    }
}

static void set_all(Slave *slave, size_t extent, size_t shift)
{
    const Variable *variable;
    for (size_t n = 0; (variable = sized_input(n)); n++) {
        Variable whole = of_extent(variable, extent);
        double values[MAX_ELEMENTS];
        fill(&whole, extent, shift + n, values);
        CHECK(slave_set(slave, &whole, values) == OK, "%s", slave->log.text);
    }
}

/* Whether they are as `set_all` made them; all zero for a shift below 0. */
static void check_all(Slave *slave, size_t extent, int shift, const char *when)
{
    const Variable *variable;
    for (size_t n = 0; (variable = sized_input(n)); n++) {
        Variable whole = of_extent(variable, extent);
        double values[MAX_ELEMENTS], expected[MAX_ELEMENTS] = {0};
        if (shift >= 0) {
            fill(&whole, extent, (size_t)shift + n, expected);
        }
        CHECK(slave_get(slave, &whole, values) == OK, "%s: %s", when, slave->log.text);
        CHECK(memcmp(values, expected, whole.count * sizeof *values) == 0, "%s: %s has other values", when, variable->name);
    }
}

static void check_sizes(Slave *slave, size_t extent)
{
    const Variable *variable;
    double values[MAX_ELEMENTS] = {0};
    for (size_t n = 0; (variable = sized_input(n)); n++) {
        Variable shorter = of_extent(variable, extent), longer = shorter;
        shorter.count--;
        longer.count++;
        CHECK_REFUSED(slave, slave_set(slave, &shorter, values), "set short", variable->name, "are left");
        CHECK_REFUSED(slave, slave_get(slave, &shorter, values), "get short", variable->name, "are left");
        CHECK_REFUSED(slave, slave_set(slave, &longer, values), "set long", "1 values more");
        CHECK_REFUSED(slave, slave_get(slave, &longer, values), "get long", "1 values more");
    }
}

static void check_last_element(Slave *slave, size_t extent)
{
    const Variable *variable;
    for (size_t n = 0; (variable = sized_input(n)); n++) {
        Variable whole = of_extent(variable, extent);
        double values[MAX_ELEMENTS];
        char name[128];
        fill(&whole, extent, 0, values);
        values[whole.count - 1] = variable->type == INT32 ? -1.0 : (double)NAN;
        snprintf(name, sizeof name, "%s[%u]", variable->name, (unsigned)whole.count);
        CHECK_REFUSED(slave, slave_set(slave, &whole, values), name, name, "allowed range");
    }
}

static void check_life(Kind kind)
{
    Slave slave;
    slave_open(&slave, kind);
    check_all(&slave, 1, -1, "new");
    set_all(&slave, 1, 0);
    set_extent(&slave, EXTENT);
    check_all(&slave, EXTENT, -1, "of a new size");
    check_sizes(&slave, EXTENT);
    set_all(&slave, EXTENT, 1);
    slave_start(&slave);
    check_last_element(&slave, EXTENT);
    check_all(&slave, EXTENT, 1, "after refusals");
    size_t before = allocator_calls();
    set_all(&slave, EXTENT, 2);
    CHECK(slave_step(&slave, 0.0, 0.01) == OK, "%s", slave.log.text);
    check_all(&slave, EXTENT, 2, "after a step");
    CHECK(allocator_calls() == before, "a step with arrays allocates");
    CHECK(slave_reset(&slave) == OK, "%s", slave.log.text);
    check_all(&slave, 1, -1, "after a reset");
    set_extent(&slave, EXTENT);
    check_all(&slave, EXTENT, -1, "grown after a reset");
    CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 5) == run_new(kind, 1, 5), "not usable after a reset");
    slave_close(&slave);
}

/* A state carries its arrays to where they have another size; and goes back over one of another size. */
static void check_states(Kind kind)
{
    Slave slave, other;
    void *state = NULL, *small = NULL, *grown = NULL, *copy = NULL;
    size_t size = 0, small_size = 0;
    slave_open(&slave, kind);
    CHECK(slave_save(&slave, &small) == OK && slave_serialized_size(&slave, small, &small_size) == OK, "%s", slave.log.text);
    CHECK(slave_save(&slave, &grown) == OK, "%s", slave.log.text);
    set_extent(&slave, EXTENT);
    slave_start(&slave);
    set_all(&slave, EXTENT, 3);
    CHECK(slave_save(&slave, &grown) == OK, "a small state is written over by a large one: %s", slave.log.text);
    CHECK(slave_save(&slave, &state) == OK && slave_serialized_size(&slave, state, &size) == OK, "%s", slave.log.text);
    CHECK(size > small_size, "the arrays are no part of the state");
    char *bytes = malloc(size);
    CHECK(slave_serialize(&slave, state, bytes, size) == OK, "%s", slave.log.text);
    CHECK_REFUSED(&slave, slave_serialize(&slave, state, bytes, small_size), "too small an array", "bytes", "needed");
    set_all(&slave, EXTENT, 4);
    CHECK(slave_restore(&slave, state) == OK, "%s", slave.log.text);
    check_all(&slave, EXTENT, 3, "restored");
    CHECK(slave_restore(&slave, small) == OK, "%s", slave.log.text);
    check_all(&slave, 1, -1, "restored to the start");
    CHECK(slave_save(&slave, &state) == OK && slave_save(&slave, &small) == OK, "written over: %s", slave.log.text);
    slave_close(&slave);

    slave_open(&other, kind);
    for (size_t length = 0; length < size; length += 1 + length / 8) {
        char *part = malloc(length + 1);
        memcpy(part, bytes, length);
        CHECK_REFUSED(&other, slave_deserialize(&other, part, length, &copy), "truncated", "bytes", "needed");
        free(part);
    }
    CHECK(slave_deserialize(&other, bytes, size, &copy) == OK && slave_restore(&other, copy) == OK, "%s", other.log.text);
    check_all(&other, EXTENT, 3, "from bytes");
    size_t before = allocator_calls();
    CHECK(slave_step(&other, 0.0, 0.01) == OK, "%s", other.log.text);
    CHECK(allocator_calls() == before, "a step after a restore allocates");
    slave_release(&other, &state);
    slave_release(&other, &small);
    slave_release(&other, &grown);
    slave_release(&other, &copy);
    slave_close(&other);
    free(bytes);
}

/* Without memory for it the size stays as it was. */
static void check_out_of_memory(Kind kind)
{
    Slave slave;
    slave_open(&slave, kind);
    set_all(&slave, 1, 0);
    double extent = EXTENT;
    CHECK(slave_enter_configuration(&slave) == OK, "%s", slave.log.text);
    fail_allocation(1);
    CHECK_REFUSED(&slave, slave_set(&slave, pick(UINT64, STRUCTURAL_PARAMETER, -1), &extent), "no memory", "out of memory");
    fail_allocation(0);
    CHECK(slave_get(&slave, pick(UINT64, STRUCTURAL_PARAMETER, -1), &extent) == OK && extent == 1.0, "it is %g", extent);
    check_all(&slave, 1, 0, "without memory");
    slave_close(&slave);
}

void test_arrays(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (sized_input(0) && slave_kinds() & kind) {
            check_life((Kind)kind);
            check_states((Kind)kind);
            check_out_of_memory((Kind)kind);
        }
    }
}
