/* UltrasonicSensor: when the comparator hears the sum of all echoes.
 *
 * The sum of all that begins and ends, with their phases, is
 *
 *     z(t) = C - (P + Q t) exp(-t) + sum of S exp(i w t) + F exp((i w - a) t)       t in ring times
 *
 * At rest each adds its amplitude a to C and P, and a (1 + i d) to Q; a shifted echo has its own S and F, and
 * adds to P (doppler.c).
 */
typedef struct Detection {
    double crossing; /* from the emission until the threshold is passed, INFINITY for never */
    Echo echo;       /* that weighs most then */
} Detection;

/* The part of the sum that turns with a shifted echo. */
typedef struct Turning {
    Shift shift;
    Phasor steady, fading; /* S, F */
} Turning;

typedef struct Onset {
    double time; /* in ring times */
    Phasor amplitude;
    double dispersion;
    Turning *mode; /* of a shifted echo */
} Onset;

typedef struct Sum {
    double time;
    Phasor constant, value, slope; /* C, P, Q */
    Turning *mode;
    int modes;
} Sum;

#define PITCH (1.0 / 256.0) /* ring times: where the sum is close to the threshold it is looked at so often */

/* By how much the square of the sum is above the threshold a little later, or earlier; and its slope there. */
static double excess_after(const Sum *sum, double later, double threshold, double *slope)
{
    double decay = exp(-later);
    Phasor ring = phasor_sum(sum->value, later, sum->slope);
    Phasor whole = phasor_sum(sum->constant, -decay, ring), change = scaled(decay, phasor_sum(ring, -1.0, sum->slope));
    for (int i = 0; i < sum->modes; i++) {
        const Turning *mode = &sum->mode[i];
        Phasor fading = scaled(exp(-mode->shift.pace * later), mode->fading);
        Phasor turn = phasor_at(mode->shift.turn * later), part = phasor_sum(mode->steady, 1.0, fading);
        Phasor turning = phasor_product((Phasor){0.0, mode->shift.turn}, part);
        whole = phasor_sum(whole, 1.0, phasor_product(part, turn));
        change = phasor_sum(change, 1.0, phasor_product(phasor_sum(turning, -mode->shift.pace, fading), turn));
    }
    *slope = 2.0 * inner_product(whole, change);
    return square_of(whole) - threshold;
}

static Phasor sum_now(const Sum *sum)
{
    Phasor whole = phasor_sum(sum->constant, -1.0, sum->value);
    for (int i = 0; i < sum->modes; i++) {
        whole = phasor_sum(phasor_sum(whole, 1.0, sum->mode[i].steady), 1.0, sum->mode[i].fading);
    }
    return whole;
}

static double square_now(const Sum *sum)
{
    return square_of(sum_now(sum));
}

static void advance_sum(Sum *sum, double later, double decay)
{
    Phasor ring = phasor_sum(sum->value, later, sum->slope);
    sum->value = scaled(decay, ring);
    sum->slope = scaled(decay, sum->slope);
    sum->time += later;
    for (int i = 0; i < sum->modes; i++) {
        Turning *mode = &sum->mode[i];
        Phasor turn = phasor_at(mode->shift.turn * later);
        double fade = exp(-mode->shift.pace * later);
        mode->steady = phasor_product(turn, mode->steady);
        mode->fading = scaled(fade, phasor_product(turn, mode->fading));
    }
}

/* Where the square has passed `threshold` since `before`: Newton's method, kept within what is known. */
static double crossing_since(const Sum *sum, double before, double threshold)
{
    double low = -before, high = 0.0, later = 0.0;
    for (int i = 0; i < 60; i++) {
        double slope, excess = excess_after(sum, later, threshold, &slope);
        double next = next_between(&low, &high, later, excess, slope), change = fabs(next - later);
        later = next;
        /* the square of the last change is left */
        if (change <= 1e-8 || high - low <= 1e-13 * (1.0 + sum->time)) {
            break;
        }
    }
    return sum->time + later;
}

/* Its change in a ring time. */
static Phasor slope_now(const Sum *sum)
{
    Phasor whole = phasor_sum(sum->value, -1.0, sum->slope);
    for (int i = 0; i < sum->modes; i++) {
        const Turning *mode = &sum->mode[i];
        Phasor turn = {0.0, mode->shift.turn};
        whole = phasor_sum(whole, 1.0, phasor_product(turn, phasor_sum(mode->steady, 1.0, mode->fading)));
        whole = phasor_sum(whole, -mode->shift.pace, mode->fading);
    }
    return whole;
}

static double modulus(Phasor a)
{
    return sqrt(square_of(a));
}

/* No more than that changes from now on: where P + Q t fades by (2 Q - P - Q t) exp(-t), in a ring time. */
static double most_bend(const Sum *sum)
{
    double bound = modulus(phasor_sum(sum->value, -2.0, sum->slope)) + exp(-1.0) * modulus(sum->slope);
    for (int i = 0; i < sum->modes; i++) {
        const Turning *mode = &sum->mode[i];
        double square = mode->shift.turn * mode->shift.turn, pace = mode->shift.pace;
        bound += square * modulus(mode->steady) + (square + pace * pace) * modulus(mode->fading);
    }
    return bound;
}

/* From `sum->time` to `until`, in ring times; INFINITY where the threshold is not passed. It leaps as far as a parabola
 * of its slope and its greatest bend is below the threshold. */
static double cross_before(Sum *sum, double until, double threshold)
{
    double limit = sqrt(threshold);
    while (sum->time < until) {
        double gap = greater(limit - modulus(sum_now(sum)), 0.0), slope = modulus(slope_now(sum));
        double safe = 2.0 * gap / (slope + sqrt(slope * slope + 2.0 * most_bend(sum) * gap));
        double rest = until - sum->time, later = lesser(greater(safe, PITCH), rest);
        advance_sum(sum, later, exp(-later));
        if (square_now(sum) >= threshold) {
            return crossing_since(sum, later, threshold);
        }
        sum->time = later == rest ? until : sum->time;
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
    return there == opening && square_now(sum) >= threshold;
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

/* Height of the threshold in shares of what an endless burst of this echo reaches. */
static double height_of(const UltrasonicSensor *sensor, Echo echo)
{
    return sensor->peak * sensor->threshold_amplitude / echo.amplitude;
}

/* Amplitude over the threshold's, with the phase of the carrier. */
static Phasor phasor_of(const UltrasonicSensor *sensor, Echo echo)
{
    Phasor carrier = phasor_at(-2.0 * PI * sensor->frequency * echo.time);
    return scaled(1.0 / sensor->threshold_amplitude, phasor_product(echo.strength, carrier));
}

static Turning turning_of(const UltrasonicSensor *sensor, Echo echo)
{
    return (Turning){.shift = shift_of(sensor, echo)};
}

/* Puts begin and end of an echo among the onsets; returns how many there are. */
static int add_onsets(const UltrasonicSensor *sensor, Echo echo, Turning *mode, Onset *onsets, int count)
{
    Phasor amplitude = phasor_of(sensor, echo), end = scaled(-1.0, amplitude);
    double arrival = echo.time / sensor->ring_time, length = sensor->burst_length;
    double dispersion = mode ? mode->shift.dispersion : whole_dispersion(sensor, echo);
    if (mode) {
        length /= mode->shift.pace;
        end = phasor_product(end, phasor_at(mode->shift.turn * length));
    }
    count = by_time(onsets, count, (Onset){arrival, amplitude, dispersion, mode});
    return by_time(onsets, count, (Onset){arrival + length, end, dispersion, mode});
}

static void begin_shifted(Sum *sum, Onset onset)
{
    Turning *mode = onset.mode;
    const Shift *shift = &mode->shift;
    double whole = shift->emphasis, d = shift->dispersion, kept = whole + d * shift->turn;
    Phasor share = phasor_quotient(onset.amplitude, shift->drift);
    Phasor steady = phasor_product(onset.amplitude, shift->resonance);
    mode->steady = phasor_sum(mode->steady, kept, steady);
    mode->fading = phasor_sum(mode->fading, -1.0, phasor_product(share, (Phasor){kept, d * shift->pace}));
    Phasor ring = phasor_sum(steady, -1.0, share);
    sum->value = phasor_sum(sum->value, 1.0, phasor_product(ring, (Phasor){whole, d}));
}

static void begin_onset(Sum *sum, Onset onset)
{
    if (onset.mode) {
        begin_shifted(sum, onset);
        return;
    }
    sum->constant = phasor_sum(sum->constant, 1.0, onset.amplitude);
    sum->value = phasor_sum(sum->value, 1.0, onset.amplitude);
    sum->slope = phasor_sum(sum->slope, 1.0, phasor_product((Phasor){1.0, onset.dispersion}, onset.amplitude));
}

/* The envelope of one echo, in shares of an endless burst's. */
static double envelope_of(const UltrasonicSensor *sensor, Echo echo, double since)
{
    if (!shifted(sensor, echo)) {
        return envelope_at(sensor, since).value;
    }
    Shift shift = shift_of(sensor, echo);
    return sqrt(square_of(shifted_response(sensor, &shift, since).value));
}

/* The echo that weighs most at a time. */
static Echo heaviest(const UltrasonicSensor *sensor, const Echo *echoes, int echo_count, double time)
{
    Echo best = silence;
    double most = 0.0;
    for (int i = 0; i < echo_count; i++) {
        double since = (time - echoes[i].time) / sensor->ring_time;
        double weight = since > 0.0 ? echoes[i].amplitude * envelope_of(sensor, echoes[i], since) : 0.0;
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
    Turning modes[MOST_ECHOES];
    int count = 0, mode_count = 0;
    double unit_time = sensor->ring_time, threshold = sensor->peak * sensor->peak;
    double opening = sensor->nearest_time / unit_time;
    for (int i = 0; i < echo_count; i++) {
        Turning *mode = shifted(sensor, echoes[i]) ? &modes[mode_count++] : NULL;
        if (mode) {
            *mode = turning_of(sensor, echoes[i]);
        }
        count = add_onsets(sensor, echoes[i], mode, onsets, count);
    }
    Sum sum = {.time = onsets[0].time, .mode = modes, .modes = mode_count};
    double crossing = INFINITY;
    for (int i = 0; i < count && !isfinite(crossing); i++) {
        begin_onset(&sum, onsets[i]);
        /* the loudest of the last echo comes within one more peak time */
        double until = i + 1 < count ? onsets[i + 1].time : greater(sum.time + sensor->peak_time, opening);
        crossing = loud_at_opening(&sum, until, opening, threshold)
            ? sensor->nearest_time
            : unit_time * cross_before(&sum, until, threshold);
    }
    return isfinite(crossing) ? (Detection){crossing, heaviest(sensor, echoes, echo_count, crossing)}
                              : (Detection){INFINITY, silence};
}

/* When a lone echo passes the threshold after the emission, INFINITY for never, 0 where only the sum can tell;
 * its amplitude becomes that of the shifted echo. */
static double lone_crossing(const UltrasonicSensor *sensor, Echo *echo)
{
    double height = height_of(sensor, *echo), loudest;
    if (!shifted(sensor, *echo)) {
        return height <= sensor->peak ? echo->time + rise_time(sensor, height, *echo) : INFINITY;
    }
    Shift shift = shift_of(sensor, *echo);
    double latest = loudest_time(sensor, &shift, &loudest);
    echo->amplitude *= loudest / sensor->peak;
    if (!(height <= loudest)) {
        return INFINITY;
    }
    if (fabs(shift.turn) > QUICK_SHIFT) {
        return 0.0;
    }
    bool early = rises_early(sensor, &shift, height);
    double since = early ? early_shifted_rise(sensor, &shift, height)
                         : plain_rise(sensor, height * sensor->peak / loudest);
    if (!early || since * shift.pace > sensor->burst_length) {
        since = shifted_rise(sensor, &shift, height, since, latest);
    }
    return echo->time + sensor->ring_time * since;
}

/* Most often the first echo passes the threshold after the comparator has opened and before the second
 * arrives: then in closed form. */
static Detection detect(const UltrasonicSensor *sensor, const Echo *echoes, int echo_count)
{
    if (echo_count == 0) {
        return (Detection){INFINITY, silence};
    }
    int earliest = 0;
    double second = INFINITY;
    for (int i = 1; i < echo_count; i++) {
        second = lesser(second, greater(echoes[earliest].time, echoes[i].time));
        earliest = echoes[i].time < echoes[earliest].time ? i : earliest;
    }
    Echo first = echoes[earliest];
    double crossing = lone_crossing(sensor, &first);
    if (crossing >= sensor->nearest_time && crossing <= second) {
        return (Detection){crossing, isfinite(crossing) ? first : silence};
    }
    Detection found = detect_sum(sensor, echoes, echo_count);
    if (shifted(sensor, found.echo)) {
        lone_crossing(sensor, &found.echo);
    }
    return found;
}
