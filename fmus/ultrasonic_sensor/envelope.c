/* UltrasonicSensor: the burst of an echo at rest, and when it is as high as the threshold.
 *
 * Two resonators in a row answer a carrier that begins with the envelope 1 - (1 + t) exp(-t), t in
 * ring times; a burst is one that begins and one that ends. Off its axis the beam is stronger for the
 * lower side of the burst's spectrum: to first order that adds -i d times the slope of the envelope,
 * d = dispersion of the beam / (carrier's angle in a ring time).
 */
/* mu - ln(1 + mu) = eta^2 / 2, mu of the sign of eta: Temme's series (1979), then Newton's method. */
static double excess_of(double eta)
{
    static const double series[] = {-571.0 / 2351462400.0, 1.0 / 204120.0, -139.0 / 5443200.0, 1.0 / 17010.0,
                                    1.0 / 4320.0, -1.0 / 270.0, 1.0 / 36.0, 1.0 / 3.0, 1.0};
    double sum = 0.0;
    for (size_t i = 0; i < sizeof series / sizeof *series; i++) {
        sum = (sum + series[i]) * eta;
    }
    if (fabs(eta) < 0.2) {
        return sum;
    }
    /* ln(1 + mu) >= -1 - eta^2 / 2 */
    double mu = sum > -0.8 ? sum : greater(sum, exp(-1.0 - 0.5 * eta * eta) - 1.0);
    double change = mu;
    for (int i = 0; i < 20 && fabs(change) > 1e-7 * fabs(mu); i++) {
        change = (mu - log(1.0 + mu) - 0.5 * eta * eta) * (1.0 + mu) / mu;
        mu = greater(mu - change, 0.5 * (mu - 1.0));
    }
    return mu;
}

static double whole_dispersion(const UltrasonicSensor *sensor, Echo echo)
{
    return dispersion_of(sensor, piston_dispersion(echo.there) + piston_dispersion(echo.back));
}

/* The envelope of one burst after `since` ring times, with its first two derivatives. */
typedef struct Envelope {
    double value, slope, bend;
} Envelope;

static Envelope envelope_at(const UltrasonicSensor *sensor, double since)
{
    double decay = exp(-since);
    Envelope burst = {1.0 - (1.0 + since) * decay, since * decay, (1.0 - since) * decay};
    double ended = since - sensor->burst_length;
    if (ended > 0.0) {
        decay = exp(-ended);
        burst.value -= 1.0 - (1.0 + ended) * decay;
        burst.slope -= ended * decay;
        burst.bend -= (1.0 - ended) * decay;
    }
    return burst;
}

/* Without dispersion, where the envelope is `height`, `margin` nepers below its peak: before the burst has
 * ended (1 + t) exp(-t) = 1 - height, later v exp(1 - v) = height / peak with v = t - peak_time + 1. */
static double plain_rise(const UltrasonicSensor *sensor, double height, double margin, Envelope *there)
{
    if (margin > sensor->burst_margin) {
        double since = excess_of(sqrt(-2.0 * log1p(-height)));
        double decay = (1.0 - height) / (1.0 + since);
        *there = (Envelope){height, since * decay, (1.0 - since) * decay};
        return since;
    }
    double before = excess_of(-sqrt(2.0 * margin)), share = height / (1.0 + before);
    *there = (Envelope){height, -before * share, (before - 1.0) * share};
    return sensor->peak_time + before;
}

#define SLIGHT_DISPERSION 1e-4 /* d^2 over the height: below, it moves the crossing by less than 3 ns */

/* How long after its arrival an echo at rest that is `margin` nepers above the threshold passes it. With
 * dispersion: Newton's method on value^2 + d^2 slope^2, from where the onset t^2 / 2 would pass. */
static double rise_time(const UltrasonicSensor *sensor, double margin, Echo echo)
{
    double d = whole_dispersion(sensor, echo), height = sensor->peak * exp(-margin), start = height;
    bool dispersed = d * d > SLIGHT_DISPERSION * height;
    if (dispersed && margin > sensor->burst_margin) {
        start = height * height / (sqrt(d * d * d * d + height * height) + d * d);
    }
    Envelope burst;
    double since = plain_rise(sensor, start, margin, &burst);
    for (int i = 0; i < 8 && dispersed; i++) {
        double excess = burst.value * burst.value + d * d * burst.slope * burst.slope - height * height;
        double slope = 2.0 * burst.slope * (burst.value + d * d * burst.bend);
        double change = slope > 0.0 ? excess / slope : 0.0;
        since = lesser(since - change, sensor->peak_time);
        /* the error is now about the square of the change */
        if (fabs(change) <= 1e-5 * since) {
            break;
        }
        burst = envelope_at(sensor, since);
    }
    return sensor->ring_time * since;
}
