/* The unit under test: its FMU as it is shipped, and what its table says. */
#include "fmu.c"

#include "subject.h"

static Subject the_subject;

/* filled at the start of main, before there is a thread */
void describe_subject(void)
{
    the_subject = (Subject){unit.name,           unit.token,           unit.variables,           unit.variable_count,
                            unit.reference_count, unit.state_count, unit.directional != NULL};
}

const Subject *subject(void)
{
    return &the_subject;
}
