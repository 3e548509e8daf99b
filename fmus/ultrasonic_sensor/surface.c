/* UltrasonicSensor: the echo of a triangle mesh, Kirchhoff's integral over what both ears see.
 *
 *     i k / (4 pi)  sum of  (n.d2 - n.d1) / (r1 r2)  beams  exp(-i k (r1 + r2))  I  area
 *
 * over pieces of at most .4 wavelength: d1 towards the piece, d2 away from it, I the mean over the piece of what
 * the length of the path does to the phase there. Each piece is an onset of the sum in envelope.c; onsets of a
 * short time share a bin, and what a bin adds to C, P and Q after its end is exact.
 */
#define LONGEST_PIECE 0.4 /* wavelengths; from .5 on, pieces in a row echo together, off the mirror point too */

enum { BINS = 2048, BATCH = 64, BINS_A_RING_TIME = 64, MOST_BURST_BINS = BINS / 4 };

/* What the onsets of one bin add to the sum at the end of the bin. */
typedef struct Bin {
    Phasor constant, value, slope;
    Phasor bent; /* half the second change of the beams with the frequency */
} Bin;

/* Bin k has the onsets from k to k + 1 spans after the emission, and lies at k modulo BINS. */
typedef struct Bins {
    double span;           /* in ring times: the burst is a whole number of them */
    int burst;             /* that number */
    int from, until;       /* bins that are taken, from <= k < until */
    int first, last, next; /* least and greatest that were met; the least beyond `until` */
    Bin bin[BINS];
} Bins;

/* A batch of lit pieces: a corner, two sides from it, and how far the surface is outside the middle. */
typedef struct Pieces {
    int count;
    double corner[3][BATCH], along[3][BATCH], across[3][BATCH], bulge[3][BATCH];
} Pieces;

/* Their onsets: the bin, and what is added to it. */
typedef struct PieceOnsets {
    int bin[BATCH];
    double sum[8][BATCH]; /* the numbers of a Bin */
} PieceOnsets;

/* What all pieces of a pass share. */
typedef struct Pass {
    int instruction_set; /* the widest of this processor */
    const UltrasonicSensor *sensor;
    const Surroundings *around;
    const Transceiver *pair;
    double strength;      /* of the whole, over the threshold's */
    double longest_piece; /* m */
    double farthest_square; /* of the range and back, m2 */
    Bins *bins;
} Pass;

/* 2 J1(x) / x over h = (x / 2)^2, its change with the logarithm of the frequency, and the second one. */
typedef struct Beam {
    double value, gain, bend;
} Beam;

/* Polynomial fitted for h up to 15.4, 60 kHz at -20 C and 90 degrees: 5e-9 off at most. */
static inline Beam beam_at(double h)
{
    const double c[] = {0.9999999946751209,      -0.49999993038950247,    0.08333318296062352,   -0.006944318189172351,
                        0.00034716823276540707,  -1.156075512749352e-05,  2.7355875785692657e-07, -4.730044787749324e-09,
                        5.714403201681599e-11,   -3.7356227316197835e-13};
    double value = h * (h * (h * (h * (h * (h * (h * (h * (h * c[9] + c[8]) + c[7]) + c[6]) + c[5]) + c[4]) + c[3]) + c[2]) + c[1]) + c[0];
    double slope = h * (h * (h * (h * (h * (h * (h * (h * 9.0 * c[9] + 8.0 * c[8]) + 7.0 * c[7]) + 6.0 * c[6]) + 5.0 * c[5]) + 4.0 * c[4])
        + 3.0 * c[3]) + 2.0 * c[2]) + c[1];
    double bend = h * (h * (h * (h * (h * (h * (h * 72.0 * c[9] + 56.0 * c[8]) + 42.0 * c[7]) + 30.0 * c[6]) + 20.0 * c[5])
        + 12.0 * c[4]) + 6.0 * c[3]) + 2.0 * c[2];
    return (Beam){value, 2.0 * h * slope, 2.0 * h * slope + 4.0 * h * h * bend};
}

/* Mean of exp(-i psi) over a triangle where psi is linear, a, b and -a - b at the corners: the sum of
 * (-i)^n 2 h_n / (n + 2)!, h_n the complete symmetric polynomials of the three (Hermite and Genocchi). To the order 12
 * it is 7e-7 off where |psi| is 2.9, grazing incidence on a triangle of the longest sides; 1e-4 on half a square. */
typedef struct MeanTurn {
    Phasor value, gain; /* and its change with the logarithm of the frequency */
} MeanTurn;

static inline MeanTurn mean_turn(double a, double b)
{
    double pairs = a * a + a * b + b * b, product = -a * b * (a + b);
    double h4 = pairs * pairs, h5 = 2.0 * pairs * product, h6 = pairs * h4 + product * product;
    double h7 = pairs * h5 + product * h4, h8 = pairs * h6 + product * h5, h9 = pairs * h7 + product * h6;
    double h10 = pairs * h8 + product * h7, h11 = pairs * h9 + product * h8, h12 = pairs * h10 + product * h9;
    double t2 = pairs * (-1.0 / 12.0), t4 = h4 * (1.0 / 360.0), t6 = h6 * (-1.0 / 20160.0), t8 = h8 * (1.0 / 1814400.0);
    double t10 = h10 * (-1.0 / 239500800.0), t12 = h12 * (1.0 / 43589145600.0);
    double t3 = product * (1.0 / 60.0), t5 = h5 * (-1.0 / 2520.0), t7 = h7 * (1.0 / 181440.0);
    double t9 = h9 * (-1.0 / 19958400.0), t11 = h11 * (1.0 / 3113510400.0);
    Phasor gain = {2.0 * t2 + 4.0 * t4 + 6.0 * t6 + 8.0 * t8 + 10.0 * t10 + 12.0 * t12,
                   3.0 * t3 + 5.0 * t5 + 7.0 * t7 + 9.0 * t9 + 11.0 * t11};
    return (MeanTurn){{1.0 + t2 + t4 + t6 + t8 + t10 + t12, t3 + t5 + t7 + t9 + t11}, gain};
}

/* exp(t) for a time within a bin. */
static inline double grown_by(double t)
{
    return 1.0 + t * (1.0 + t * (1.0 / 2.0 + t * (1.0 / 6.0 + t * (1.0 / 24.0))));
}

/* One loop without a branch, so that the compiler takes several pieces at a time. */
INLINED void onsets_of_pieces(const Pass *pass, const Pieces *restrict pieces, PieceOnsets *restrict onsets)
{
    const UltrasonicSensor *sensor = pass->sensor;
    const Vector ear = pass->pair->transmitter, other = pass->pair->receiver, drift = pass->pair->velocity;
    const Vector axis = pass->pair->axis, other_axis = pass->pair->receiver_axis;
    const double speed = sensor->speed_of_sound, k = sensor->wave_number, frequency = sensor->frequency;
    const double margin = speed * speed - dot(drift, drift), slowness = 1.0 / speed, dilation = 1.0 / margin;
    const double beam = 0.25 * k * k * PISTON_RADIUS * PISTON_RADIUS;
    const double angle = 1.0 / (2.0 * PI * frequency * sensor->ring_time);
    const double span = pass->bins->span, rate = 1.0 / (sensor->ring_time * span);
    const double loss = sensor->absorption / DECIBEL_PER_NEPER * speed * sensor->ring_time; /* nepers a ring time */
    const double strength = pass->strength;
    const int count = pieces->count;
    for (int i = 0; i < count; i++) {
        const Vector corner = {pieces->corner[0][i], pieces->corner[1][i], pieces->corner[2][i]};
        const Vector side = {pieces->along[0][i], pieces->along[1][i], pieces->along[2][i]};
        const Vector across = {pieces->across[0][i], pieces->across[1][i], pieces->across[2][i]};
        const Vector bulge = {pieces->bulge[0][i], pieces->bulge[1][i], pieces->bulge[2][i]};
        Vector one = scale(-1.0 / 3.0, add(side, across)), two = add(side, one); /* corners from the middle */
        Vector point = add(subtract(corner, one), bulge), area = cross(side, across); /* twice */
        Vector leg = subtract(point, ear);
        double first = sqrt(dot(leg, leg)), bounce = first * slowness;
        Vector incident = scale(1.0 / first, leg);
        Vector back = subtract(add_scaled(other, bounce, drift), point);
        double approach = dot(back, drift);
        double wait = (approach + sqrt(approach * approach + margin * dot(back, back))) * dilation;
        double second = speed * wait;
        Vector reflected = scale(1.0 / second, add_scaled(back, wait, drift));
        double ahead = dot(incident, axis), behind = -dot(reflected, other_axis);
        Vector along = subtract(incident, reflected); /* the slope of the path's length */
        double time = bounce + wait, place = time * rate;
        int bin = (int)place;
        double late = (place - 1.0 - (double)bin) * span;

        double weight = -0.5 * strength * (1.0 - loss * late) * dot(area, along) / (first * second);
        Beam there = beam_at(beam * (1.0 - ahead * ahead)), here = beam_at(beam * (1.0 - behind * behind));
        double both = there.value * here.value, gain = there.gain * here.value + there.value * here.gain;
        double bend = there.bend * here.value + 2.0 * there.gain * here.gain + there.value * here.bend;
        MeanTurn mean = mean_turn(k * dot(along, one), k * dot(along, two));
        Phasor turn = turned_back(frequency * time);
        Phasor whole = {-weight * turn.im, weight * turn.re}, echo = phasor_product(whole, mean.value);
        Phasor change = phasor_product(whole, mean.gain);
        change = (Phasor){angle * (gain * echo.re + both * change.re), angle * (gain * echo.im + both * change.im)};
        Phasor bent = {0.5 * bend * echo.re, 0.5 * bend * echo.im};
        echo = (Phasor){both * echo.re, both * echo.im};
        /* (1 + x) (echo + change x), for k in front of it all is in proportion to the frequency */
        double grown = grown_by(late);
        Phasor value = {echo.re + angle * change.re, echo.im + angle * change.im};
        Phasor slope = {echo.re - angle * (change.re + echo.im) - change.im,
                        echo.im - angle * (change.im - echo.re) + change.re};
        onsets->bin[i] = bin;
        onsets->sum[0][i] = echo.re;
        onsets->sum[1][i] = echo.im;
        onsets->sum[2][i] = grown * (value.re - late * slope.re);
        onsets->sum[3][i] = grown * (value.im - late * slope.im);
        onsets->sum[4][i] = grown * slope.re;
        onsets->sum[5][i] = grown * slope.im;
        onsets->sum[6][i] = bent.re;
        onsets->sum[7][i] = bent.im;
    }
}

/* The same operations, four or eight pieces at a time. */
IN_EVERY_INSTRUCTION_SET(find_onsets, (const Pass *pass, const Pieces *restrict pieces, PieceOnsets *restrict onsets),
                         onsets_of_pieces(pass, pieces, onsets))

static int least(int a, int b)
{
    return b < a ? b : a;
}

static int greatest(int a, int b)
{
    return b > a ? b : a;
}

/* `factor` times what a bin adds. */
static void add_bin(Bin *sum, double factor, const Bin *bin)
{
    sum->constant = phasor_sum(sum->constant, factor, bin->constant);
    sum->value = phasor_sum(sum->value, factor, bin->value);
    sum->slope = phasor_sum(sum->slope, factor, bin->slope);
    sum->bent = phasor_sum(sum->bent, factor, bin->bent);
}

static void hear_pieces(const Pass *pass, Pieces *pieces)
{
    Bins *bins = pass->bins;
    PieceOnsets onsets;
    find_onsets[pass->instruction_set](pass, pieces, &onsets);
    for (int i = 0; i < pieces->count; i++) {
        int k = onsets.bin[i];
        if (k >= bins->until) {
            bins->next = least(bins->next, k);
        } else if (k >= bins->from) {
            bins->first = least(bins->first, k);
            bins->last = greatest(bins->last, k);
            Bin onset = {{onsets.sum[0][i], onsets.sum[1][i]},
                         {onsets.sum[2][i], onsets.sum[3][i]},
                         {onsets.sum[4][i], onsets.sum[5][i]},
                         {onsets.sum[6][i], onsets.sum[7][i]}};
            add_bin(&bins->bin[k % BINS], 1.0, &onset);
        }
    }
    pieces->count = 0;
}
