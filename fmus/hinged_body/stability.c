/* HingedBody: up to which step a solver of a fixed step is stable, by linear theory.
 *
 * Near any angle the hinge is x'' = -stiffness x - damping x'. A step multiplies angle and rate by a matrix, and is
 * stable while both its eigenvalues are within 1: |det| <= 1 and |trace| <= 1 + det (Jury).
 */
typedef struct Oscillator {
    double stiffness, damping; /* 1/s2, 1/s */
} Oscillator;

/* The muscle, and the most that weight and tip force add to it at any angle. */
static Oscillator stiffest_oscillator(const Hinge *hinge)
{
    Oscillator most = {hinge->stiffness + hypot(hinge->resting.cosine, hinge->resting.sine), hinge->damping};
    return most;
}

static bool bounded(double trace, double determinant)
{
    static const double rounding = 1e-9;
    return fabs(determinant) <= 1.0 + rounding && fabs(trace) <= 1.0 + determinant + rounding;
}

/* Of a Runge-Kutta method with as many stages as order: it multiplies by 1 + z + z^2 / 2 + ..., z = h times the matrix
 * of the oscillator, of which every power is a + b z since z^2 = sum z - product, by its eigenvalues. */
static bool runge_kutta_bounded(Oscillator o, double h, int stages)
{
    double sum = -h * o.damping, product = h * h * o.stiffness;
    double a = 1.0, b = 0.0;
    for (int k = stages; k >= 1; k--) {
        double next = -b * product / k;
        b = (a + b * sum) / k;
        a = 1.0 + next;
    }
    return bounded(2.0 * a + b * sum, a * a + a * b * sum + b * b * product);
}

static bool step_is_stable(int64_t solver, Oscillator o, double h)
{
    switch ((HingedBodySolverKind)solver) {
    case HINGED_BODY_SOLVER_EXPLICIT_EULER: return runge_kutta_bounded(o, h, 1);
    case HINGED_BODY_SOLVER_SEMI_IMPLICIT_EULER:
        return bounded(2.0 - h * h * o.stiffness - h * o.damping, 1.0 - h * o.damping);
    case HINGED_BODY_SOLVER_RK4: return runge_kutta_bounded(o, h, 4);
    case HINGED_BODY_SOLVER_TAYLOR: return true;
    case HINGED_BODY_SOLVER_AUTOMATIC: return true;
    }
    return true;
}

/* The largest stable step below an unstable one, by bisection. */
static double stable_step(int64_t solver, Oscillator o, double unstable)
{
    double stable = 0.0;
    for (int i = 0; i < 40; i++) {
        double middle = 0.5 * (stable + unstable);
        if (step_is_stable(solver, o, middle)) {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    return stable;
}
