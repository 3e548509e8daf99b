/* UltrasonicSensor: when the comparator hears the sum of all echoes.
 *
 * Two resonators in a row answer a carrier that begins with the envelope 1 - (1 + t) exp(-t), t in
 * ring times; a burst is one that begins and one that ends. The sum of all, with their phases, is
 *
 *     z(t) = C - (P + Q t) exp(-t)        C, P, Q complex
 *
 * and each beginning or end adds its amplitude a to C and P, and a (1 + i d) to Q. Off its axis the beam
 * is stronger for the lower side of the burst's spectrum: to first order that adds -i d times the slope
 * of the envelope, d = dispersion of the beam / (carrier's angle in a ring time).
 */
typedef struct Detection {
    double crossing; /* from the emission until the threshold is passed, INFINITY for never */
    Echo echo;       /* that weighs most then */
} Detection;

typedef struct Onset {
    double time; /* in ring times */
    Phasor amplitude;
    double dispersion;
} Onset;

typedef struct Sum {
    double time;
    Phasor constant, value, slope; /* C, P, Q */
} Sum;

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

static double dispersion_of(const UltrasonicSensor *sensor, Echo echo)
{
    double beam = piston_dispersion(echo.there) + piston_dispersion(echo.back);
    return -beam / (2.0 * PI * sensor->frequency * sensor->ring_time);
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

/* How long after its arrival an echo that is `margin` nepers above the threshold passes it. With
 * dispersion: Newton's method on value^2 + d^2 slope^2, from where the onset t^2 / 2 would pass. */
static double rise_time(const UltrasonicSensor *sensor, double margin, Echo echo)
{
    double d = dispersion_of(sensor, echo), height = sensor->peak * exp(-margin), start = height;
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

static Phasor value_after(const Sum *sum, double later)
{
    Phasor ring = phasor_sum(sum->value, later, sum->slope);
    return phasor_sum(sum->constant, -exp(-later), ring);
}

static double square_of(Phasor a)
{
    return a.re * a.re + a.im * a.im;
}

static void advance_sum(Sum *sum, double later, double decay)
{
    Phasor ring = phasor_sum(sum->value, later, sum->slope);
    sum->value = (Phasor){decay * ring.re, decay * ring.im};
    sum->slope = (Phasor){decay * sum->slope.re, decay * sum->slope.im};
    sum->time += later;
}

/* Where the square passes `threshold` between 0 and `later`: by halving and by the secant. */
static double crossing_within(const Sum *sum, double later, double threshold)
{
    double low = 0.0, high = later;
    for (int i = 0; i < 100 && high - low > 1e-13 * (1.0 + sum->time); i++) {
        double below = square_of(value_after(sum, low)) - threshold;
        double above = square_of(value_after(sum, high)) - threshold;
        double secant = low - below * (high - low) / (above - below);
        double probe = i % 2 ? 0.5 * (low + high) : lesser(greater(secant, low), high);
        bool passed = square_of(value_after(sum, probe)) >= threshold;
        low = passed ? low : probe;
        high = passed ? probe : high;
    }
    return high;
}

#define SAMPLES_A_RING_TIME 64

/* From `sum->time` to `until`, in ring times; INFINITY where the threshold is not passed. */
static double cross_before(Sum *sum, double until, double threshold)
{
    const double pitch = 1.0 / SAMPLES_A_RING_TIME, decay = exp(-pitch);
    double limit = sqrt(threshold);
    while (sum->time < until) {
        double rest = until - sum->time;
        double bound = sqrt(square_of(sum->constant)) + sqrt(square_of(sum->value)) + sqrt(square_of(sum->slope));
        bool leap = bound < limit || rest < pitch; /* nothing more can happen, or it is the last sample */
        double later = leap ? rest : pitch;
        if (bound >= limit && square_of(value_after(sum, later)) >= threshold) {
            return sum->time + crossing_within(sum, later, threshold);
        }
        advance_sum(sum, later, leap ? exp(-later) : decay);
        sum->time = leap ? until : sum->time;
    }
    return INFINITY;
}

/* Up to where the comparator opens, or to `until`: true where it opens to a sum above the threshold. */
static bool loud_at_opening(Sum *sum, double until, double opening, double threshold)
{
    if (sum->time >= opening) {
        return false;
    }
    double there = lesser(until, opening), later = there - sum->time;
    advance_sum(sum, later, exp(-later));
    sum->time = there;
    return there == opening && square_of(value_after(sum, 0.0)) >= threshold;
}

static int by_time(Onset *onsets, int count, Onset onset)
{
    int place = count;
    for (; place > 0 && onsets[place - 1].time > onset.time; place--) {
        onsets[place] = onsets[place - 1];
    }
    onsets[place] = onset;
    return count + 1;
}

/* Amplitude over the threshold's, with the phase of the carrier. */
static Phasor phasor_of(const UltrasonicSensor *sensor, Echo echo)
{
    double amplitude = exp((echo.level - sensor->threshold) / DECIBEL_PER_NEPER);
    Phasor turn = phasor_at(echo.phase - 2.0 * PI * sensor->frequency * echo.time);
    return (Phasor){amplitude * turn.re, amplitude * turn.im};
}

/* The echo that weighs most at a time. */
static Echo heaviest(const UltrasonicSensor *sensor, const Echo *echoes, int echo_count, double time)
{
    Echo best = silence;
    double most = -INFINITY;
    for (int i = 0; i < echo_count; i++) {
        double since = (time - echoes[i].time) / sensor->ring_time;
        double height = since > 0.0 ? envelope_at(sensor, since).value : 0.0;
        double weight = height > 0.0 ? echoes[i].level + DECIBEL_PER_NEPER * log(height) : -INFINITY;
        if (weight > most) {
            most = weight;
            best = echoes[i];
        }
    }
    return best;
}

/* The sum of all, from its first echo on. While the transmitter rings the comparator is deaf: an echo that
 * comes before it opens is heard then, if it still rings loud enough. */
static Detection detect_sum(const UltrasonicSensor *sensor, const Echo *echoes, int echo_count)
{
    Onset onsets[2 * MOST_ECHOES];
    int count = 0;
    double unit_time = sensor->ring_time, threshold = sensor->peak * sensor->peak;
    double opening = sensor->nearest_time / unit_time;
    for (int i = 0; i < echo_count; i++) {
        Phasor amplitude = phasor_of(sensor, echoes[i]);
        double arrival = echoes[i].time / unit_time;
        double dispersion = dispersion_of(sensor, echoes[i]), end = arrival + sensor->burst_length;
        count = by_time(onsets, count, (Onset){arrival, amplitude, dispersion});
        count = by_time(onsets, count, (Onset){end, {-amplitude.re, -amplitude.im}, dispersion});
    }
    Sum sum = {.time = onsets[0].time};
    double crossing = INFINITY;
    for (int i = 0; i < count && !isfinite(crossing); i++) {
        sum.constant = phasor_sum(sum.constant, 1.0, onsets[i].amplitude);
        sum.value = phasor_sum(sum.value, 1.0, onsets[i].amplitude);
        Phasor slope = phasor_product((Phasor){1.0, onsets[i].dispersion}, onsets[i].amplitude);
        sum.slope = phasor_sum(sum.slope, 1.0, slope);
        /* the loudest of the last echo comes within one more peak time */
        double until = i + 1 < count ? onsets[i + 1].time : greater(sum.time + sensor->peak_time, opening);
        crossing = loud_at_opening(&sum, until, opening, threshold)
            ? sensor->nearest_time
            : unit_time * cross_before(&sum, until, threshold);
    }
    return isfinite(crossing) ? (Detection){crossing, heaviest(sensor, echoes, echo_count, crossing)}
                              : (Detection){INFINITY, silence};
}

/* Most often the first echo passes the threshold after the comparator has opened and before the second
 * arrives: then in closed form. */
static Detection detect(const UltrasonicSensor *sensor, const Echo *echoes, int echo_count)
{
    Echo first = silence;
    double second = INFINITY;
    for (int i = 0; i < echo_count; i++) {
        second = lesser(second, greater(first.time, echoes[i].time));
        first = echoes[i].time < first.time ? echoes[i] : first;
    }
    if (first.level >= sensor->threshold) {
        double crossing = first.time + rise_time(sensor, (first.level - sensor->threshold) / DECIBEL_PER_NEPER, first);
        if (crossing >= sensor->nearest_time && crossing <= second) {
            return (Detection){crossing, first};
        }
    }
    bool several = echo_count > 1 || first.level >= sensor->threshold;
    return several ? detect_sum(sensor, echoes, echo_count) : (Detection){INFINITY, silence};
}
