/* UltrasonicSensor: when the comparator hears the sum of a mesh and of echoes.
 *
 * As sum.c, but from bin to bin: at the end of each the sum and its slope are exact, between two ends it is a cubic.
 * The burst is a whole number of bins, so what a bin adds is taken back that many bins later.
 */
enum { PEAK_BINS = MOST_BURST_BINS + BINS_A_RING_TIME }; /* from an onset to its peak, at most */

/* The sum's parts at the end of the last bin. */
typedef struct Listening {
    Bin mesh;
    Sum others;
    int bin; /* that comes next */
    Onset onsets[2 * MOST_ECHOES];
    int count, heard; /* of the onsets: all, and those in the sum */
    Turning modes[MOST_ECHOES];
    Phasor loudest; /* of the mesh, so far */
    int loudest_bin;
} Listening;

/* A phasor and its slope over ring times. */
typedef struct Sample {
    Phasor value, slope;
} Sample;

static Sample sample_of_mesh(const Listening *listening)
{
    const Bin *mesh = &listening->mesh;
    return (Sample){phasor_sum(mesh->constant, -1.0, mesh->value), phasor_sum(mesh->value, -1.0, mesh->slope)};
}

static Sample sample_of_all(const Listening *listening)
{
    const Sum *others = &listening->others;
    Sample whole = sample_of_mesh(listening);
    whole.value = phasor_sum(whole.value, 1.0, sum_now(others));
    whole.slope = phasor_sum(whole.slope, 1.0, slope_now(others));
    return whole;
}

/* Hermite's cubic at a share of the way, from values and slopes at both ends, `span` apart. */
static double cubic_at(double share, double span, double value, double slope, double next_value, double next_slope)
{
    double rest = 1.0 - share;
    return rest * rest * (value * (1.0 + 2.0 * share) + span * slope * share)
        + share * share * (next_value * (3.0 - 2.0 * share) - span * next_slope * rest);
}

static Phasor value_between(double share, double span, Sample before, Sample after)
{
    return (Phasor){
        cubic_at(share, span, before.value.re, before.slope.re, after.value.re, after.slope.re),
        cubic_at(share, span, before.value.im, before.slope.im, after.value.im, after.slope.im),
    };
}

static double square_between(double share, double span, Sample before, Sample after)
{
    return square_of(value_between(share, span, before, after));
}

/* What the air leaves on the way to the end of a bin; within the bin, the pieces see to it. */
static double left_until(const UltrasonicSensor *sensor, double time)
{
    return left_by_air(sensor->speed_of_sound * sensor->ring_time * time, sensor->absorption);
}

/* Onsets of bin k, none where there are none. */
static const Bin *onsets_of(const Bins *bins, int k)
{
    static const Bin none;
    return k >= bins->first && k <= bins->last ? &bins->bin[k % BINS] : &none;
}

/* What bin k adds. The beams' second change with the frequency, x^2, is a second difference from bin to bin; it acts
 * in the middle of the bin, and k in front of it all gains with the frequency. */
static void add_onsets_of(const UltrasonicSensor *sensor, const Bins *bins, int k, double sign, Bin *mesh)
{
    if (k < bins->first - 1 || k > bins->last + 1) {
        return;
    }
    const double turn = 2.0 * PI * sensor->frequency * sensor->ring_time, middle = -0.5 * bins->span;
    double factor = sign * left_until(sensor, (double)(k + 1) * bins->span);
    const Bin *bin = onsets_of(bins, k);
    Phasor bent = phasor_sum(onsets_of(bins, k - 1)->bent, 1.0, onsets_of(bins, k + 1)->bent);
    bent = scaled(-1.0 / (turn * bins->span * turn * bins->span), phasor_sum(bent, -2.0, bin->bent));
    Phasor slope = scaled(grown_by(middle), phasor_product(bent, (Phasor){1.0, 1.0 / turn}));
    add_bin(mesh, factor, bin);
    mesh->constant = phasor_sum(mesh->constant, factor, bent);
    mesh->value = phasor_sum(mesh->value, factor, phasor_sum(scaled(grown_by(middle), bent), -middle, slope));
    mesh->slope = phasor_sum(mesh->slope, factor, slope);
}

static void pass_bin_of_mesh(const UltrasonicSensor *sensor, const Bins *bins, Listening *listening, double decay)
{
    Bin *mesh = &listening->mesh;
    mesh->value = scaled(decay, phasor_sum(mesh->value, bins->span, mesh->slope));
    mesh->slope = scaled(decay, mesh->slope);
    add_onsets_of(sensor, bins, listening->bin, 1.0, mesh);
    add_onsets_of(sensor, bins, listening->bin - bins->burst, -1.0, mesh);
    Phasor now = sample_of_mesh(listening).value;
    if (square_of(now) > square_of(listening->loudest)) {
        listening->loudest = now;
        listening->loudest_bin = listening->bin;
    }
    listening->bin++;
}

static void advance_others(Sum *others, double until, double span, double decay)
{
    double later = until - others->time;
    advance_sum(others, later, later == span ? decay : exp(-later));
    others->time = until;
}

static void pass_bin(const UltrasonicSensor *sensor, const Bins *bins, Listening *listening, double decay)
{
    pass_bin_of_mesh(sensor, bins, listening, decay);
    double end = (double)listening->bin * bins->span;
    for (; listening->heard < listening->count && listening->onsets[listening->heard].time <= end; listening->heard++) {
        advance_others(&listening->others, listening->onsets[listening->heard].time, bins->span, decay);
        begin_onset(&listening->others, listening->onsets[listening->heard]);
    }
    if (listening->heard > 0) {
        advance_others(&listening->others, end, bins->span, decay);
    }
    listening->others.time = end;
}

/* As a share of the bin from `low` on, where the sum passes; it has at the end. */
static double passing_share(double low, double span, Sample before, Sample after, double threshold)
{
    double high = 1.0;
    for (int i = 0; i < 40; i++) {
        double middle = 0.5 * (low + high);
        bool passed = square_between(middle, span, before, after) >= threshold;
        low = passed ? low : middle;
        high = passed ? middle : high;
    }
    return high;
}

/* The mesh as one echo, from its value at the crossing. It was as loud as it ever has been if it is heard when the
 * comparator opens, and came so early that it had its peak then; else it is as loud as it becomes within a burst's peak
 * time, and came so early that it is as high as it is at the crossing: in phase with its peak, where dispersion, which
 * turns the slope by 90 degrees, has no share. */
static Echo echo_of_mesh(const UltrasonicSensor *sensor, const Bins *bins, Listening *listening, double crossing,
                         Phasor value)
{
    const double decay = exp(-bins->span);
    const int now = listening->bin - 1, end = listening->bin + (int)(sensor->peak_time / bins->span);
    if (crossing > sensor->nearest_time) {
        listening->loudest = value;
        listening->loudest_bin = now;
    }
    while (listening->bin < end) {
        pass_bin_of_mesh(sensor, bins, listening, decay);
    }
    double most = sqrt(square_of(listening->loudest)), in_phase = inner_product(value, listening->loudest) / most;
    double arrival = ((double)listening->loudest_bin + 1.0) * bins->span - sensor->peak_time;
    if (listening->loudest_bin >= now) {
        double height = sensor->peak * (in_phase > 0.0 ? in_phase : sqrt(square_of(value))) / most;
        arrival = (crossing - rise_time(sensor, lesser(height, sensor->peak), silence)) / sensor->ring_time;
    }
    double amplitude = sensor->threshold_amplitude * most / sensor->peak;
    return plain_echo(sensor->ring_time * greater(arrival, 0.0), amplitude);
}

/* The mesh or the echo that weighs most at the crossing. */
static Echo heaviest_of_all(const UltrasonicSensor *sensor, const Bins *bins, Listening *listening, const Echo *echoes,
                            int echo_count, double crossing, Phasor value)
{
    Echo echo = heaviest(sensor, echoes, echo_count, crossing);
    double since = (crossing - echo.time) / sensor->ring_time, height = sqrt(square_of(value));
    if (since > 0.0 && height_of(sensor, echo) * height < sensor->peak * envelope_of(sensor, echo, since)) {
        if (shifted(sensor, echo)) {
            lone_crossing(sensor, &echo);
        }
        return echo;
    }
    return echo_of_mesh(sensor, bins, listening, crossing, value);
}

/* Bin by bin up to `end`; the comparator is deaf until it opens. */
static Detection listen(const UltrasonicSensor *sensor, const Bins *bins, Listening *listening, int end,
                        const Echo *echoes, int echo_count)
{
    const double span = bins->span, decay = exp(-span), threshold = sensor->peak * sensor->peak;
    const double opening = sensor->nearest_time / sensor->ring_time;
    Sample mesh = sample_of_mesh(listening), before = sample_of_all(listening);
    while (listening->bin < end) {
        double deaf = opening / span - (double)listening->bin; /* share of the bin */
        pass_bin(sensor, bins, listening, decay);
        Sample mesh_after = sample_of_mesh(listening), after = sample_of_all(listening);
        double low = greater(deaf, 0.0);
        bool opens = deaf > 0.0 && deaf <= 1.0 && square_between(deaf, span, before, after) >= threshold;
        if (opens || (deaf < 1.0 && square_of(after.value) >= threshold)) {
            double share = opens ? deaf : passing_share(low, span, before, after, threshold);
            double crossing = opens ? sensor->nearest_time
                                    : ((double)(listening->bin - 1) + share) * span * sensor->ring_time;
            Phasor value = value_between(share, span, mesh, mesh_after);
            Echo echo = heaviest_of_all(sensor, bins, listening, echoes, echo_count, crossing, value);
            return (Detection){crossing, echo};
        }
        mesh = mesh_after;
        before = after;
    }
    return (Detection){INFINITY, silence};
}

static int bin_at(const UltrasonicSensor *sensor, const Bins *bins, double time)
{
    return (int)(time / (sensor->ring_time * bins->span));
}

static void fill_bins(const UltrasonicSensor *sensor, const Surroundings *around, const Mesh *mesh, int from, int until,
                      Bins *bins)
{
    memset(bins->bin, 0, sizeof bins->bin);
    bins->from = from;
    bins->until = until;
    bins->first = bins->next = INT_MAX;
    bins->last = INT_MIN;
    hear_surface(sensor, around, mesh, bins);
}

static void place_onsets(const UltrasonicSensor *sensor, const Echo *echoes, int echo_count, Listening *listening)
{
    listening->others.mode = listening->modes;
    for (int i = 0; i < echo_count; i++) {
        Turning *mode = NULL;
        if (shifted(sensor, echoes[i])) {
            mode = &listening->modes[listening->others.modes++];
            *mode = turning_of(sensor, echoes[i]);
        }
        listening->count = add_onsets(sensor, echoes[i], mode, listening->onsets, listening->count);
    }
}

/* The sum of a mesh and of echoes. A mesh that is too deep for the bins is heard part by part. */
static Detection detect_with_mesh(const UltrasonicSensor *sensor, const Surroundings *around, const Mesh *mesh,
                                  const Echo *echoes, int echo_count)
{
    Bins bins;
    bins.burst = (int)lesser(ceil(sensor->burst_length * (double)BINS_A_RING_TIME), MOST_BURST_BINS);
    bins.span = sensor->burst_length / (double)bins.burst;
    const int until = bin_at(sensor, &bins, sensor->farthest_time) + 1;
    fill_bins(sensor, around, mesh, 0, until, &bins);
    Detection alone = detect(sensor, echoes, echo_count);
    if (bins.last < bins.first || alone.crossing <= (double)bins.first * bins.span * sensor->ring_time) {
        return alone;
    }
    Listening listening = {.bin = bins.first - 1};
    place_onsets(sensor, echoes, echo_count, &listening);
    if (listening.count > 0) {
        listening.bin = least(listening.bin, (int)(listening.onsets[0].time / bins.span));
    }
    if (bins.last - bins.first >= BINS) {
        fill_bins(sensor, around, mesh, bins.first, bins.first + BINS, &bins);
    }
    Detection found = {INFINITY, silence};
    while (bins.next < until && !isfinite(found.crossing)) {
        int end = bins.from + BINS - PEAK_BINS;
        found = listen(sensor, &bins, &listening, end, echoes, echo_count);
        if (!isfinite(found.crossing)) {
            int from = end - bins.burst - 1; /* what ends from there on began here */
            fill_bins(sensor, around, mesh, from, from + BINS, &bins);
        }
    }
    if (!isfinite(found.crossing)) {
        double last = listening.count > 0 ? listening.onsets[listening.count - 1].time : 0.0;
        last = greater(greater(last, (double)(bins.last + bins.burst) * bins.span), sensor->nearest_time / sensor->ring_time);
        int end = (int)(last / bins.span) + PEAK_BINS;
        found = listen(sensor, &bins, &listening, end, echoes, echo_count);
    }
    return found;
}
