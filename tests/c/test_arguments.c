/* Arguments that are NULL, too many or too few, and instances that are none. */
#include "check.h"
#include "tests.h"

static void check_no_instance(void)
{
    Slave none = {.kind = CO_SIMULATION};
    void *state = NULL;
    size_t size = 0;
    for (size_t i = 0; i < call_count; i++) {
        CHECK(calls[i].make(&none) == ERROR, "%s without an instance", calls[i].name);
    }
    CHECK(slave_save(&none, &state) == ERROR && !state, "save without an instance");
    CHECK(slave_restore(&none, NULL) == ERROR, "restore without an instance");
    CHECK(slave_serialized_size(&none, NULL, &size) == ERROR, "size without an instance");
    CHECK(slave_serialize(&none, NULL, NULL, 0) == ERROR, "serialize without an instance");
    CHECK(slave_deserialize(&none, NULL, 0, &state) == ERROR && !state, "deserialize without an instance");
    CHECK(slave_release(&none, &state) == OK, "nothing is released without harm");
    CHECK(slave_release(&none, NULL) == OK, "nothing is released without harm");
    slave_close(&none);
}

void test_arguments(void)
{
    check_no_instance();
    check_version_arguments();
}
