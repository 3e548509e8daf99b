/* What the test programs know of the unit's inside: its table of variables. */
#ifndef ULNA_TEST_SUBJECT_H
#define ULNA_TEST_SUBJECT_H

#include "variable.h"

typedef struct Subject {
    const char *name, *token;
    const Variable *variables;
    size_t variable_count, reference_count, state_count;
    bool differentiable;
} Subject;

void describe_subject(void);
const Subject *subject(void);

#endif
