/* HingedBody: the solver that chooses order and step of the Taylor series by the tolerance.
 *
 * A series ends when three terms in a row are below what the tolerance allows over the step: from rest at level, two in
 * a row vanish by symmetry. Where the largest order does not get there, the step becomes the fraction of it at which
 * its last terms do.
 */
/* Whether the angle enters by its sine and cosine at any time of the step. */
static bool is_swayed(const Hinge *hinge)
{
    const Turning *by = &hinge->resting, *change = &hinge->resting_slope;
    return hinge->turned || by->cosine != 0.0 || by->sine != 0.0 || change->cosine != 0.0 || change->sine != 0.0;
}

/* How fast anything here can change, 1/s: a bound for choosing a first step, not an estimate of errors. */
static double fastest(const Hinge *hinge, bool swayed, Swing swing, double elapsed)
{
    Turning by = hinge->resting, change = hinge->resting_slope;
    double sway = fabs(by.cosine) + fabs(by.sine) + elapsed * (fabs(change.cosine) + fabs(change.sine));
    double speed = hinge->damping + sqrt(hinge->stiffness + sway) + (swayed ? fabs(swing.rate) : 0.0);
    if (hinge->turned) {
        Drive now = hinge_drive(hinge, elapsed);
        speed += norm(now.spin) + sqrt(norm(now.spin_rate)) + cbrt(norm(hinge->slope.spin_rate));
    }
    return speed;
}

/* What a term may add: the share of the tolerance, but not less than the rounding of the value itself. */
static double allowed(double tolerance, double h, double value)
{
    return fmax(tolerance * h, 0x1p-53 * fabs(value));
}

/* The fraction of the step at which term n would be small enough, if the tolerance over it is that much less too. */
static double fitting(double term, double limit, int n)
{
    return fabs(term) > limit ? pow(limit / fabs(term), 1.0 / (n - 1)) : 1.0;
}

/* The largest term n of the cosines and sines, which the next orders take. */
static double wave_term(const SwingSeries *series, int n)
{
    double single = fmax(fabs(series->single.cosine[n]), fabs(series->single.sine[n]));
    if (!series->hinge->turned) {
        return single;
    }
    return fmax(single, fmax(fabs(series->twice.cosine[n]), fabs(series->twice.sine[n])));
}

/* How much a wave of height 1 could change the rate over the step. */
static double sway(const SwingSeries *series)
{
    Turning by = series->turning[0];
    double change = series->hinge->turned ? 0.0 : fabs(series->turning[1].cosine) + fabs(series->turning[1].sine);
    return series->h * (fabs(by.cosine) + fabs(by.sine) + fabs(by.double_cosine) + fabs(by.double_sine) + change);
}

/* From the state at the start of the communication step to that at its end. */
static Status adaptive_swing(const Hinge *hinge, Swing *swing, double step, double tolerance, Log *log)
{
    /* beyond that the largest order is not enough for any tolerance, and below that many steps no one waits */
    static const double longest = 8.0, shortest = 1e-5;
    enum { enough = 3 };
    SwingSeries series;
    Rotation anchor = rotation(hinge->body->anchor_orientation);
    series.swayed = is_swayed(hinge);
    double elapsed = 0.0;
    while (elapsed < step) {
        double speed = fastest(hinge, series.swayed, *swing, elapsed), rest = step - elapsed;
        double h = speed * rest > longest ? longest / speed : rest;
        /* terms may grow up to this order, and a turned anchor may take some orders to be felt; fmin also
         * where inputs overflow, which the part of the step that fits then tells */
        int least = 2 + (int)fmin(speed * h, longest) + (hinge->turned ? 4 : 0);
        double angle_limit = allowed(tolerance, h, swing->angle), rate_limit = allowed(tolerance, h, swing->rate);
        int order = 0, small = 0;
        start_series(&series, hinge, *swing, anchor, elapsed, h);
        double swayed_by = series.swayed ? sway(&series) : 0.0;
        while (order < TAYLOR_MOST && (small < enough || order < least)) {
            extend_series(&series, ++order);
            bool fits = fabs(series.angle[order]) <= angle_limit && fabs(series.rate[order]) <= rate_limit
                        && (!series.swayed || swayed_by * wave_term(&series, order) <= rate_limit);
            small = fits ? small + 1 : 0;
        }
        double part = 1.0;
        for (int n = order - enough; small < enough && n <= order; n++) {
            part = fmin(part, fitting(series.angle[n], angle_limit, n));
            part = fmin(part, fitting(series.rate[n], rate_limit, n));
        }
        if (!(part * h >= fmin(shortest * step, rest))) {
            return report(log, STATUS_ERROR,
                          "a step of %g s takes internal steps of %g s: angle %g rad, rate %g rad/s or the inputs are too "
                          "large",
                          step, part * h, swing->angle, swing->rate);
        }
        *swing = swing_of_series(&series, order, part);
        bool last = part * h >= rest;
        if (hinge->turned && !last) {
            anchor = anchor_of_series(&series, order, part);
        }
        elapsed = last ? step : elapsed + part * h;
    }
    return STATUS_OK;
}
