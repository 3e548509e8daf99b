/* CompliantJoint: the check of its axis; a step does nothing. */
#include "unit.h"
#include "mechanics_checks.h"
#include "equations.h"

#include <math.h>

static Status compliant_joint_check(const CompliantJoint *joint, Log *log)
{
    return check_axis(joint->axis, log);
}

/* The wrenches follow the frames at once. */
static Status compliant_joint_step(CompliantJoint *joint, double step, Log *log)
{
    (void)joint;
    (void)step;
    (void)log;
    return STATUS_OK;
}
