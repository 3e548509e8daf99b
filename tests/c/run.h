/* A run of the unit under test on inputs that a seed decides, and a digest of all it gave. */
#ifndef ULNA_TEST_RUN_H
#define ULNA_TEST_RUN_H

#include "slave.h"

typedef struct Run {
    Slave *slave;
    double time;
    uint64_t random; /* xorshift; never 0 */
    uint64_t digest; /* of the bits of everything read */
    size_t failures; /* calls that did not return OK */
} Run;

uint64_t random_bits(uint64_t *random);

/* In [0, 1). */
double random_fraction(uint64_t *random);

/* Values within the limits of the variable, quaternions of a norm near 1. */
void random_values(uint64_t *random, const Variable *variable, double *values);

/* Whether an importer sees and reads it as single elements. */
bool is_readable(const Variable *variable);

Run run_from(Slave *slave, double time, uint64_t seed);

/* Sets all inputs, takes a step, reads everything. */
void run_step(Run *run);

/* Digest of so many steps from a time on, of an instance that is ready to run. */
uint64_t run_steps(Slave *slave, double time, uint64_t seed, size_t steps);

/* Digest of a whole life from the state Instantiated on. */
uint64_t run_life(Slave *slave, uint64_t seed, size_t steps);

/* The same of a new instance of that kind. */
uint64_t run_new(Kind kind, uint64_t seed, size_t steps);

#endif
