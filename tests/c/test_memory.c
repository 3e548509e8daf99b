/* No allocation between two communication points; and no harm when there is no memory. */
#include "allocations.h"
#include "check.h"
#include "pick.h"
#include "run.h"
#include "tests.h"

static void differentiate(Slave *slave)
{
    const Variable *output = pick(FLOAT64, OUTPUT, CONTINUOUS), *input = pick(FLOAT64, INPUT, CONTINUOUS);
    double result[MAX_ELEMENTS];
    if (subject()->differentiable) {
        CHECK(slave_directional(slave, output, input, result) == OK, "%s", slave->log.text);
    }
}

static void check_no_allocation(Kind kind)
{
    Slave slave;
    void *state = NULL;
    slave_open(&slave, kind);
    slave_start(&slave);
    CHECK(slave_save(&slave, &state) == OK, "%s", slave.log.text);
    Run run = run_from(&slave, 0.0, 1);
    size_t before = allocator_calls();
    for (int i = 0; i < 100; i++) {
        run_step(&run);
    }
    differentiate(&slave);
    CHECK(slave_step(&slave, -1.0, 0.01) == ERROR, "a refused step allocates nothing either");
    CHECK(slave_save(&slave, &state) == OK && slave_restore(&slave, state) == OK, "%s", slave.log.text);
    size_t calls_made = allocator_calls() - before;
    CHECK(run.failures == 0, "%s", slave.log.text);
    CHECK(calls_made == 0, "kind %d: %zu calls of the allocator in a run of steps", (int)kind, calls_made);
    slave_release(&slave, &state);
    CHECK(allocator_calls() == before + 1, "the count works: a released state is one call");
    slave_close(&slave);
}

/* The n-th allocation of a life fails, for every n. */
static void check_out_of_memory(Kind kind)
{
    size_t refused = 0;
    for (size_t n = 1; n < 30; n++) {
        Slave slave;
        void *state = NULL;
        fail_allocation(n);
        slave_open_as(&slave, kind, "test", subject()->token);
        if (!slave.instance) {
            CHECK(slave.log.lines == 1, "allocation %zu: nothing is said", n);
            refused++;
            continue;
        }
        int status = slave_enter_initialization(&slave, 0.0, NULL);
        status = status == OK ? slave_exit_initialization(&slave) : status;
        status = status == OK ? slave_save(&slave, &state) : status;
        if (status != OK) {
            CHECK_REFUSED(&slave, status, "no memory", "out of memory");
            CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 5) == run_new(kind, 1, 5), "not usable after reset");
            refused++;
        }
        fail_allocation(0);
        slave_release(&slave, &state);
        slave_close(&slave);
    }
    CHECK(refused >= 5, "kind %d: only %zu allocations could fail", (int)kind, refused);
}

void test_memory(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (slave_kinds() & kind) {
            check_no_allocation((Kind)kind);
            check_out_of_memory((Kind)kind);
        }
    }
}
