/* The tests; main.c runs them by name. */
#ifndef ULNA_TEST_TESTS_H
#define ULNA_TEST_TESTS_H

void test_life_cycle(void);
void test_modes(void);
void test_values(void);
void test_time(void);
void test_arguments(void);
void test_arrays(void);
void test_states(void);
void test_memory(void);
void test_threads(void);
void test_random_calls(void);

#endif
