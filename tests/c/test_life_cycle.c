/* From instantiation to the end, of one instance and of two; the same run gives the same bits. */
#include "check.h"
#include "run.h"
#include "tests.h"

enum { STEPS = 40 };

static void check_repeatable(Kind kind)
{
    uint64_t digest = run_new(kind, 1, STEPS);
    CHECK(run_new(kind, 1, STEPS) == digest, "kind %d: a second instance gives other bits", (int)kind);
    CHECK(run_new(kind, 2, STEPS) != digest, "kind %d: other inputs give the same bits", (int)kind);

    Slave slave;
    slave_open(&slave, kind);
    run_life(&slave, 2, STEPS);
    CHECK(slave_reset(&slave) == OK, "reset: %s", slave.log.text);
    CHECK(run_life(&slave, 1, STEPS) == digest, "kind %d: a reset instance gives other bits than a new one", (int)kind);
    slave_close(&slave);
}

static void check_interleaved(Kind kind)
{
    Slave first, second;
    slave_open(&first, kind);
    slave_open(&second, kind);
    slave_start(&first);
    slave_start(&second);
    Run a = run_from(&first, 0.0, 1), b = run_from(&second, 0.0, 2);
    for (size_t i = 0; i < STEPS; i++) {
        run_step(&a);
        run_step(&b);
    }
    CHECK(a.failures + b.failures == 0, "%s %s", first.log.text, second.log.text);
    slave_close(&first);
    CHECK(slave_terminate(&second) == OK, "kind %d: one instance outlives the other", (int)kind);
    slave_close(&second);
    CHECK(a.digest == run_new(kind, 1, STEPS) && b.digest == run_new(kind, 2, STEPS),
          "kind %d: two instances in turn give other bits than one after the other", (int)kind);
}

static void check_end_in_every_mode(Kind kind)
{
    for (unsigned mode = INSTANTIATED; mode <= TERMINATED; mode *= 2) {
        Slave slave;
        slave_open(&slave, kind);
        slave_reach(&slave, (Mode)mode);
        slave_close(&slave);
    }
}

static void check_wrong_instantiation(Kind kind)
{
    Slave slave;
    slave_open_as(&slave, kind, "test", "{00000000-0000-0000-0000-000000000000}");
    CHECK(!slave.instance && slave.log.lines == 1, "kind %d: a token of another unit is refused, and said", (int)kind);
    slave_open_as(&slave, kind, "test", NULL);
    CHECK(!slave.instance && slave.log.lines == 1, "kind %d: no token is refused, and said", (int)kind);
    slave_open_as(&slave, kind, NULL, subject()->token);
    CHECK(!slave.instance && slave.log.lines == 1, "kind %d: no name is refused, and said", (int)kind);
    slave_open_as(&slave, kind, "", subject()->token);
    CHECK(!slave.instance && slave.log.lines == 1, "kind %d: an empty name is refused, and said", (int)kind);
    slave_open_as(&slave, kind, "%s%n 100%", subject()->token);
    CHECK(slave.instance, "kind %d: a name is not a format", (int)kind);
    CHECK(slave_terminate(&slave) == ERROR && slave.log.lines == 1, "and is none in a message");
    slave_close(&slave);
}

void test_life_cycle(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (slave_kinds() & kind) {
            check_repeatable((Kind)kind);
            check_interleaved((Kind)kind);
            check_end_in_every_mode((Kind)kind);
            check_wrong_instantiation((Kind)kind);
        }
    }
    if (!(slave_kinds() & MODEL_EXCHANGE)) {
        Slave slave;
        slave_open_as(&slave, MODEL_EXCHANGE, "test", subject()->token);
        CHECK(!slave.instance && slave.log.lines == 1, "a unit without states is refused for model exchange, and said");
    }
}
