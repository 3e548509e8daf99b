/* UltrasonicSensor: the burst of an echo whose carrier is shifted, Doppler.
 *
 * The echo is the transmitter's burst in quicker time, a = 1 + doppler, with its carrier off the receiver's
 * resonance by w = 2 pi frequency doppler, in ring times. What begins drives the receiver with
 *
 *     x(t) = exp(i w t) (1 - exp(-a t)),  y' = x - y
 *     y(t) = (exp(i w t) - exp(-t)) / (1 + i w) - (exp((i w - a) t) - exp(-t)) / e,   e = 1 + i w - a
 *
 * and what ends, a burst's length later, is the same with the carrier as it then is. To first order the
 * beam weighs the transmitter's spectrum from the shifted carrier, the receiver's from the resonance:
 *
 *     z = (1 - d1 w) y - i (d1 + d2) y',         d1, d2 dispersion of the beams, as in envelope.c
 */
#define SLIGHT_SHIFT 1e-6 /* radians a ring time: .003 mm/s; below, an echo is at rest */
#define QUICK_SHIFT 1.0   /* above, the envelope may rise and fall more than once */
#define CLOSE_PEAK 1e-2   /* ring times: what Taylor leaves of the peak is below 1e-6 */

/* What the receiver makes of an echo. */
typedef struct Shift {
    double pace, turn;           /* a, w */
    Phasor resonance, drift;     /* 1 / (1 + i w), e */
    double dispersion, emphasis; /* d1 + d2, 1 - d1 w */
} Shift;

static double dispersion_of(const UltrasonicSensor *sensor, double beam)
{
    return -(1.0 / (2.0 * PI * sensor->frequency * sensor->ring_time)) * beam;
}

static double turn_of(const UltrasonicSensor *sensor, Echo echo)
{
    return 2.0 * PI * sensor->frequency * sensor->ring_time * echo.doppler;
}

static bool shifted(const UltrasonicSensor *sensor, Echo echo)
{
    return fabs(turn_of(sensor, echo)) > SLIGHT_SHIFT;
}

static Shift shift_of(const UltrasonicSensor *sensor, Echo echo)
{
    double there = dispersion_of(sensor, piston_dispersion(echo.there));
    double back = dispersion_of(sensor, piston_dispersion(echo.back));
    Shift shift = {.pace = 1.0 + echo.doppler, .turn = turn_of(sensor, echo)};
    shift.resonance = phasor_quotient((Phasor){1.0, 0.0}, (Phasor){1.0, shift.turn});
    shift.drift = (Phasor){-echo.doppler, shift.turn};
    shift.dispersion = there + back;
    shift.emphasis = 1.0 - there * shift.turn;
    return shift;
}

/* z after some ring times and its first two derivatives. */
typedef struct Response {
    Phasor value, slope, bend;
} Response;

/* (exp(e t) - 1) / e, t ring times after the begin; `grown` is exp(e t). */
static Phasor growth(Phasor e, double t, Phasor grown)
{
    Phasor small = scaled(t, e);
    if (small.re * small.re + small.im * small.im > 0.04) {
        return phasor_quotient((Phasor){grown.re - 1.0, grown.im}, e);
    }
    Phasor sum = {1.0, 0.0};
    for (int k = 11; k > 1; k--) {
        sum = phasor_sum((Phasor){1.0, 0.0}, 1.0 / k, phasor_product(small, sum));
    }
    return scaled(t, sum);
}

/* Of a burst that begins at 0 and never ends. */
static Response begin_response(const Shift *shift, double t)
{
    double decay = exp(-t), fade = exp(-shift->pace * t);
    Phasor turn = phasor_at(shift->turn * t), w = {0.0, shift->turn};
    Phasor grown = scaled(fade / decay, turn);
    Phasor x = scaled(1.0 - fade, turn), fading = scaled(shift->pace * fade, turn);
    Phasor y = phasor_product(shift->resonance, phasor_sum(turn, -1.0, (Phasor){decay, 0.0}));
    y = phasor_sum(y, -decay, growth(shift->drift, t, grown));
    /* y' = x - y, x' = w x + a exp((w - a) t), and so on */
    Phasor x1 = phasor_sum(fading, 1.0, phasor_product(w, x));
    Phasor x2 = phasor_sum(phasor_product(w, x1), -shift->pace, fading);
    x2 = phasor_sum(x2, 1.0, phasor_product(w, fading));
    Phasor y1 = phasor_sum(x, -1.0, y), y2 = phasor_sum(x1, -1.0, y1), y3 = phasor_sum(x2, -1.0, y2);
    Phasor i = {0.0, shift->dispersion};
    double whole = shift->emphasis;
    return (Response){
        phasor_sum(scaled(whole, y), -1.0, phasor_product(i, y1)),
        phasor_sum(scaled(whole, y1), -1.0, phasor_product(i, y2)),
        phasor_sum(scaled(whole, y2), -1.0, phasor_product(i, y3)),
    };
}

/* Of the burst, `t` ring times after the arrival. */
static Response shifted_response(const UltrasonicSensor *sensor, const Shift *shift, double t)
{
    Response response = begin_response(shift, t);
    double length = sensor->burst_length / shift->pace;
    if (t > length) {
        Response end = begin_response(shift, t - length);
        Phasor carrier = phasor_at(shift->turn * length);
        response.value = phasor_sum(response.value, -1.0, phasor_product(carrier, end.value));
        response.slope = phasor_sum(response.slope, -1.0, phasor_product(carrier, end.slope));
        response.bend = phasor_sum(response.bend, -1.0, phasor_product(carrier, end.bend));
    }
    return response;
}

/* When a shifted echo is loudest, in ring times: where the square is flat, by Newton's method. How high it then is, by
 * Taylor from where that ends. */
static double loudest_time(const UltrasonicSensor *sensor, const Shift *shift, double *height)
{
    double time = sensor->peak_time, latest = sensor->peak_time + 1.0, best = 0.0;
    for (double t = 0.03125; fabs(shift->turn) > QUICK_SHIFT && t < latest; t += 0.03125) {
        Phasor value = shifted_response(sensor, shift, t).value;
        time = inner_product(value, value) > best ? t : time;
        best = greater(best, inner_product(value, value));
    }
    double square = 0.0, change = 1.0;
    for (int i = 0; i < 20 && fabs(change) > CLOSE_PEAK; i++) {
        Response there = shifted_response(sensor, shift, time);
        double slope = inner_product(there.value, there.slope);
        double bend = inner_product(there.slope, there.slope) + inner_product(there.value, there.bend);
        change = bend < 0.0 ? -slope / bend : 0.0;
        time = lesser(greater(time + lesser(greater(change, -0.25), 0.25), 0.0), latest);
        square = inner_product(there.value, there.value) + slope * change;
    }
    *height = sqrt(square);
    return time;
}

/* Up to `loudest` the envelope of a shift that is not quick only rises: Newton's method on the square, kept
 * within what is known. */
static double shifted_rise(const UltrasonicSensor *sensor, const Shift *shift, double height, double guess,
                           double loudest)
{
    double low = 0.0, high = loudest, time = lesser(guess, loudest);
    for (int i = 0; i < 60; i++) {
        Response there = shifted_response(sensor, shift, time);
        double excess = inner_product(there.value, there.value) - height * height;
        double slope = 2.0 * inner_product(there.value, there.slope);
        double next = next_between(&low, &high, time, excess, slope), change = fabs(next - time);
        time = next;
        if (change <= 1e-8 * time || high - low <= 1e-14 * high) {
            break;
        }
    }
    return time;
}
