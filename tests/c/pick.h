/* Variables of the unit under test that stand for their kind. */
#ifndef ULNA_TEST_PICK_H
#define ULNA_TEST_PICK_H

#include "subject.h"

/* The first that is of this type, causality and variability (any: -1), no state, no stream; NULL for none. */
static inline const Variable *pick(int type, int causality, int variability)
{
    const Subject *unit = subject();
    for (size_t i = 0; i < unit->variable_count; i++) {
        const Variable *variable = &unit->variables[i];
        if ((type < 0 || variable->type == type) && variable->causality == causality && variable->group != STREAM &&
            (variability < 0 || variable->variability == variability)) {
            return variable;
        }
    }
    return NULL;
}

#endif
