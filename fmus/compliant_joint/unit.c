/* CompliantJoint: the check of its axis; a step does nothing. */
#include "unit.h"
#include "equations.h"

#include <math.h>

static Status compliant_joint_check(const CompliantJoint *joint, Log *log)
{
    double length = norm(joint->axis);
    if (fabs(length - 1.0) > 1e-9) {
        return report(log, STATUS_ERROR,
                      "axis = [%g, %g, %g] has length %.12g; allowed range: 1 within 1e-9, divide it by its length",
                      joint->axis.x, joint->axis.y, joint->axis.z, length);
    }
    return STATUS_OK;
}

/* The wrenches follow the frames at once. */
static Status compliant_joint_step(CompliantJoint *joint, double step, Log *log)
{
    (void)joint;
    (void)step;
    (void)log;
    return STATUS_OK;
}
