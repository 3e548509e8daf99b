/* HingedBody: Taylor series of the swing, order and step chosen as they are needed.
 *
 * Coefficients are of powers of time over the step h, so that each is also its term at the end of the step.
 * With s and c the sine and cosine of the angle, s' = c rate and c' = -s rate: every coefficient follows from those
 * before it by sums of products (Jorba & Zou 2005, Experimental Mathematics 14:99). The axes of an anchor that turns
 * follow dX/dt = w(t) x X with w a polynomial, without the approximation that the fixed steps make.
 */
enum { TAYLOR_MOST = 24 };

/* Cosine and sine of a multiple of the angle. */
typedef struct Wave {
    real cosine[TAYLOR_MOST + 1], sine[TAYLOR_MOST + 1];
} Wave;

typedef struct SwingSeries {
    const Hinge *hinge;
    real h;
    bool swayed; /* the angle enters by its sine and cosine */
    real angle[TAYLOR_MOST + 1], rate[TAYLOR_MOST + 1];
    Wave single, twice;
    Turning turning[TAYLOR_MOST + 1];
    /* where the anchor turns: its axes in the world, and its angular velocity in them */
    Rotation anchor[TAYLOR_MOST + 1];
    Spin spin[TAYLOR_MOST + 1];
    Drive drive, drive_slope; /* at the start of the step, and what they change by over it */
} SwingSeries;

static Rotation turned_axes(Rotation axes, Vector by)
{
    Rotation turned = {cross(by, axes.x), cross(by, axes.y), cross(by, axes.z)};
    return turned;
}

static Rotation add_scaled_axes(Rotation a, real factor, Rotation b)
{
    Rotation sum = {add_scaled(a.x, factor, b.x), add_scaled(a.y, factor, b.y), add_scaled(a.z, factor, b.z)};
    return sum;
}

/* Coefficient n of the axes of the anchor, from dX/dt = w x X. */
static Rotation anchor_coefficient(const SwingSeries *series, int n)
{
    const Vector *spin[3] = {&series->drive.spin, &series->drive.spin_rate, &series->drive_slope.spin_rate};
    real share[3] = {1.0, series->h, 0.5 * series->h};
    Rotation sum = {0};
    for (int k = 0; k < 3 && k < n; k++) {
        sum = add_scaled_axes(sum, share[k], turned_axes(series->anchor[n - 1 - k], *spin[k]));
    }
    Rotation none = {0};
    return add_scaled_axes(none, series->h / n, sum);
}

/* Coefficient n of the angular acceleration by angle where the anchor turns. */
static Turning turned_coefficient(SwingSeries *series, int n)
{
    const Hinge *hinge = series->hinge;
    const Drive *drive = &series->drive, *slope = &series->drive_slope;
    const Rotation *anchor = series->anchor;
    Turning turning = turning_by_loads(hinge, anchor[n], drive);
    Vector spin = to_body(anchor[n], drive->spin), spin_rate = to_body(anchor[n], drive->spin_rate);
    if (n > 0) {
        Turning later = turning_by_loads(hinge, anchor[n - 1], slope);
        turning.even += later.even;
        turning.cosine += later.cosine;
        turning.sine += later.sine;
        spin = add_scaled(spin, series->h, to_body(anchor[n - 1], drive->spin_rate));
        spin_rate = add(spin_rate, to_body(anchor[n - 1], slope->spin_rate));
    }
    if (n > 1) {
        spin = add_scaled(spin, 0.5 * series->h, to_body(anchor[n - 2], slope->spin_rate));
    }
    if (n < 2) {
        turning.even += hinge->per_torque * (n == 0 ? drive->torque : slope->torque);
    }
    series->spin[n] = spin_parts(hinge, spin);
    add_turning_by_spin_rate(&turning, hinge, spin_rate);
    for (int j = 0; j <= n; j++) {
        add_turning_by_spins(&turning, &series->spin[j], &series->spin[n - j]);
    }
    return turning;
}

static Turning scaled_turning(real factor, Turning by)
{
    Turning scaled = {factor * by.cosine, factor * by.double_cosine, factor * by.even, factor * by.sine,
                      factor * by.double_sine};
    return scaled;
}

static void start_wave(Wave *wave, real angle)
{
    wave->cosine[0] = cos(angle);
    wave->sine[0] = sin(angle);
}

/* Coefficient n of cosine and sine of `multiple` times the angle. */
static void extend_wave(Wave *wave, real multiple, const real *rate, real h, int n)
{
    real cosine = 0.0, sine = 0.0;
    for (int j = 0; j < n; j++) {
        cosine -= rate[j] * wave->sine[n - 1 - j];
        sine += rate[j] * wave->cosine[n - 1 - j];
    }
    wave->cosine[n] = multiple * h / n * cosine;
    wave->sine[n] = multiple * h / n * sine;
}

/* Coefficient n of the angular acceleration. */
static real acceleration_coefficient(const SwingSeries *series, int n)
{
    const Hinge *hinge = series->hinge;
    real sum = -hinge->stiffness * series->angle[n] - hinge->damping * series->rate[n];
    int last = hinge->turned || n < 1 ? n : 1;
    sum += hinge->turned || n <= 1 ? series->turning[n].even : 0.0;
    for (int j = 0; series->swayed && j <= last; j++) {
        sum += series->turning[j].cosine * series->single.cosine[n - j]
               + series->turning[j].sine * series->single.sine[n - j];
    }
    for (int j = 0; hinge->turned && j <= n; j++) {
        sum += series->turning[j].double_cosine * series->twice.cosine[n - j]
               + series->turning[j].double_sine * series->twice.sine[n - j];
    }
    return sum;
}

/* The series from `elapsed` on, order 0; `anchor`: its axes then. */
static void start_series(SwingSeries *series, const Hinge *hinge, Swing swing, Rotation anchor, real elapsed, real h)
{
    series->hinge = hinge;
    series->h = h;
    series->angle[0] = swing.angle;
    series->rate[0] = swing.rate;
    start_wave(&series->single, swing.angle);
    if (hinge->turned) {
        start_wave(&series->twice, 2.0 * swing.angle);
        series->drive = hinge_drive(hinge, elapsed);
        series->drive_slope = hinge->slope;
        series->drive_slope.torque *= h;
        series->drive_slope.fall = scale(h, hinge->slope.fall);
        series->drive_slope.tip_force = scale(h, hinge->slope.tip_force);
        series->drive_slope.tip_torque = scale(h, hinge->slope.tip_torque);
        series->drive_slope.spin_rate = scale(h, hinge->slope.spin_rate);
        series->anchor[0] = anchor;
        series->turning[0] = turned_coefficient(series, 0);
    } else {
        series->turning[0] = hinge_turning(hinge, elapsed);
        series->turning[1] = scaled_turning(h, hinge->resting_slope);
    }
}

/* Order n, when all orders before it are there. */
static void extend_series(SwingSeries *series, int n)
{
    real h = series->h;
    real acceleration = acceleration_coefficient(series, n - 1);
    series->angle[n] = h / n * series->rate[n - 1];
    if (series->swayed) {
        extend_wave(&series->single, 1.0, series->rate, h, n);
    }
    if (series->hinge->turned) {
        extend_wave(&series->twice, 2.0, series->rate, h, n);
        series->anchor[n] = anchor_coefficient(series, n);
        series->turning[n] = turned_coefficient(series, n);
    }
    series->rate[n] = h / n * acceleration;
}

/* The sum up to `order` at the fraction `at` of the step. */
static Swing swing_of_series(const SwingSeries *series, int order, real at)
{
    Swing sum = {series->angle[order], series->rate[order]};
    for (int n = order - 1; n >= 0; n--) {
        sum.angle = series->angle[n] + at * sum.angle;
        sum.rate = series->rate[n] + at * sum.rate;
    }
    return sum;
}

static Rotation anchor_of_series(const SwingSeries *series, int order, real at)
{
    Rotation sum = series->anchor[order];
    for (int n = order - 1; n >= 0; n--) {
        sum = add_scaled_axes(series->anchor[n], at, sum);
    }
    return sum;
}
