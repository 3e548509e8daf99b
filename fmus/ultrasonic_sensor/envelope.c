/* UltrasonicSensor: the burst of an echo at rest, and when it is as high as the threshold.
 *
 * Two resonators in a row answer a carrier that begins with the envelope 1 - (1 + t) exp(-t), t in
 * ring times; a burst is one that begins and one that ends. Off its axis the beam is stronger for the
 * lower side of the burst's spectrum: to first order that adds -i d times the slope of the envelope,
 * d = dispersion of the beam / (carrier's angle in a ring time).
 */
/* mu - ln(1 + mu) = eta^2 / 2, mu of the sign of eta: Temme's series (1979) in four chains by eta^4, which a
 * processor follows side by side; from |eta| = 1 on, where it is 1e-16 of mu off, Newton's method. */
static double excess_of(double eta)
{
    static const double series[] = {
        1.0, 0.33333333333333333, 0.027777777777777778, -0.0037037037037037037,
        0.00023148148148148148, 5.8788947677836567e-5, -2.5536449147560259e-5, 4.8990789731530472e-6,
        -2.4282761229777691e-7, -1.85406221071516e-7, 7.5424648554118964e-8, -1.4721627280688399e-8,
        5.1598873410780758e-10, 7.32986413160022e-10, -2.9213573456355688e-10, 5.7173122388979939e-11,
        -1.5008349408791912e-12, -3.2393178514169028e-12, 1.282207790561443e-12, -2.5138346400570878e-13,
        5.2401866818838737e-15, 1.5326196647277206e-14, -6.0538640105137481e-15, 1.1889539086269768e-15,
    };
    double square = eta * eta, fourth = square * square;
    double chain[4];
    for (int i = 0; i < 4; i++) {
        const double *s = series + i;
        chain[i] = s[0] + fourth * (s[4] + fourth * (s[8] + fourth * (s[12] + fourth * (s[16] + fourth * s[20]))));
    }
    double sum = eta * ((chain[0] + eta * chain[1]) + square * (chain[2] + eta * chain[3]));
    if (fabs(eta) < 1.0) {
        return sum;
    }
    /* ln(1 + mu) >= -1 - eta^2 / 2 */
    double mu = eta > 0.0 ? eta + square / 3.0 : greater(sum, exp(-1.0 - 0.5 * square) - 1.0);
    double change = mu;
    for (int i = 0; i < 20 && fabs(change) > 1e-7 * fabs(mu); i++) {
        change = (mu - log(1.0 + mu) - 0.5 * square) * (1.0 + mu) / mu;
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

/* Without dispersion and before the burst has ended, where the envelope is `height`: up to .245 from the polynomial
 * t / s in s, (1 + t) exp(-t) = 1 - s^2 / 2, that interpolates Lambert's function in Chebyshev's points, 1e-10 off;
 * from there on by Temme's series. */
static double early_rise(double height)
{
    if (height > 0.245) {
        return excess_of(sqrt(-2.0 * log1p(-height)));
    }
    static const double series[] = {
        0.99999999994687551, 0.333333355154845805, 0.152776303974115651, 0.0796683364188596378,
        0.0439813784537542945, 0.0300807996811522813, -0.00452409235302136487, 0.0737987699513998108,
        -0.126782604428193806, 0.177628274898108798, -0.130291813834139435, 0.0484703513220339246,
    };
    double s = sqrt(2.0 * height), square = s * s, fourth = square * square;
    double chain[4];
    for (int i = 0; i < 4; i++) {
        chain[i] = series[i] + fourth * (series[i + 4] + fourth * series[i + 8]);
    }
    return s * ((chain[0] + s * chain[1]) + square * (chain[2] + s * chain[3]));
}

/* Without dispersion; once the burst has ended v exp(1 - v) = height / peak with v = t - peak_time + 1. */
static double plain_rise(const UltrasonicSensor *sensor, double height)
{
    return height < sensor->burst_height ? early_rise(height)
                                         : sensor->peak_time + excess_of(-sqrt(2.0 * log(sensor->peak / height)));
}

/* No more than that of the beams, from their arguments: x J2 / J1 < x^2 / 2 up to x = 2. */
static double most_dispersion(const UltrasonicSensor *sensor, Echo echo)
{
    double arguments = echo.there + echo.back;
    return arguments < 1.0 ? 2.0 * arguments / (2.0 * PI * sensor->frequency * sensor->ring_time) : INFINITY;
}

/* d^2 over the height: */
#define SLIGHT_DISPERSION 1e-4 /* it moves the crossing by less than 3 ns */
#define SMALL_DISPERSION 1e-2  /* what its square moves it by is less than 1 ns */

/* One step of Halley's method from `since`, where the envelope is `burst`, to where value^2 + d^2 slope^2 is that of
 * `height`; no longer than twice Newton's. */
static double change_towards(double height, double d, Envelope burst)
{
    double whole = burst.value + d * d * burst.bend, twist = -2.0 * burst.bend - burst.slope;
    double excess = burst.value * burst.value + d * d * burst.slope * burst.slope - height * height;
    double slope = 2.0 * burst.slope * whole;
    double bend = 2.0 * (burst.bend * whole + burst.slope * (burst.slope + d * d * twist));
    double below = greater(2.0 * slope * slope - excess * bend, slope * slope);
    return slope > 0.0 ? -2.0 * excess * slope / below : 0.0;
}

/* How many ring times after its arrival the envelope of an echo at rest is `height`, up to its peak. Small dispersion
 * moves that by -d^2 slope / (2 height); with more, the search begins where the onset t^2 / 2 would pass. */
static double rise_with(const UltrasonicSensor *sensor, double height, double dispersion)
{
    double start = height, square = dispersion * dispersion;
    bool early = height < sensor->burst_height;
    if (early && square <= SMALL_DISPERSION * height) {
        double since = early_rise(height); /* slope: since exp(-since), from the height */
        return since - 0.5 * square * since * (1.0 - height) / ((1.0 + since) * height);
    }
    if (square <= SLIGHT_DISPERSION * height) {
        return plain_rise(sensor, height);
    }
    if (early) {
        start = height * height / (sqrt(square * square + height * height) + square);
    }
    double since = plain_rise(sensor, start), decay = (1.0 - start) / (1.0 + since);
    Envelope burst = {start, since * decay, (1.0 - since) * decay};
    if (!early) {
        burst = envelope_at(sensor, since);
    }
    double change = change_towards(height, dispersion, burst);
    since = lesser(since + change, sensor->peak_time);
    /* of `since`, about the cube of the last change is left: 1e-7, 2 nm */
    for (int i = 0; i < 8 && fabs(change) > 5e-3 * since; i++) {
        change = change_towards(height, dispersion, envelope_at(sensor, since));
        since = lesser(since + change, sensor->peak_time);
    }
    return since;
}

/* The same in s; most often the beams need not be looked at. */
static double rise_time(const UltrasonicSensor *sensor, double height, Echo echo)
{
    double most = most_dispersion(sensor, echo);
    double rise = most * most <= SLIGHT_DISPERSION * height
        ? plain_rise(sensor, height)
        : rise_with(sensor, height, whole_dispersion(sensor, echo));
    return sensor->ring_time * rise;
}

#define LOW_ONSET 0.17  /* shares of an endless burst, and */
#define SLIGHT_TURN 0.01 /* of the dispersion, radians: up to there early_shifted_rise is within 5 ns, 1 um */
#define SHORT_CHANGE 2e-3 /* ring times: some thousandths of the last change are left */

/* Whether that may be taken: of a shift that is not quick. */
static bool rises_early(const UltrasonicSensor *sensor, const Shift *shift, double height)
{
    return height < lesser(LOW_ONSET, sensor->burst_height) && fabs(shift->turn * shift->dispersion) <= SLIGHT_TURN;
}

/* That of a shifted echo before its burst ends. In the frame of its carrier what begins is, a = 1 + e the pace,
 *
 *     u = a t^2 / 2 E(exp(-t X)),  X = a p + (1 + i w) q,  p and q even over p, q >= 0, p + q <= 1
 *
 * By the first three cumulants of X, an echo at rest has its height and its slope's share for
 *
 *     |u| = a v(t) exp(-e t / 3 + (e - w^2) t^2 / 36 + w^2 t^3 / 540),  Im u' / u = -w (1 / 3 - t / 18 - t^2 / 180)
 *
 * and z = (whole u - i d u') exp(i w t), whole = 1 + d2 w. */
static double early_shifted_rise(const UltrasonicSensor *sensor, const Shift *shift, double height)
{
    double d = shift->dispersion, w = shift->turn, e = shift->pace - 1.0, whole = shift->emphasis + d * w;
    double t = rise_with(sensor, height, d), change = INFINITY;
    for (int i = 0; i < 4 && change > SHORT_CHANGE; i++) {
        double grown = t * (-e / 3.0 + t * ((e - w * w) / 36.0 + t * w * w / 540.0));
        double turned = whole - d * w * (1.0 / 3.0 - t * (1.0 / 18.0 + t / 180.0));
        double share = shift->pace * turned * (1.0 + grown * (1.0 + 0.5 * grown));
        double next = rise_with(sensor, height / share, d / turned);
        change = fabs(next - t);
        t = next;
    }
    return t;
}
