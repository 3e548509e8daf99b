/* Elliptic integrals of the first kind, from moduli whose complement is known without cancellation. */
#include <float.h>
#include <math.h>

static const double pi = 3.14159265358979323846;

/* K, from the complementary modulus k' = sqrt(1 - k^2): pi / 2 over the arithmetic-geometric mean of 1 and k'. */
static double complete_elliptic(double complement)
{
    double a = 1.0, b = complement;
    if (b == 0.0) {
        return INFINITY;
    }
    while (a - b > 1e-8 * a) {
        double mean = 0.5 * (a + b);
        b = sqrt(a * b);
        a = mean;
    }
    return pi / (a + b); /* one more mean; the two then differ by a relative 1e-17 */
}

/* Carlson's RF(x, y, z) by duplication, at most one argument zero; F(phi, k) is
 * sin(phi) RF(cos^2, 1 - k^2 sin^2, 1). The series' last term is of degree 7: DLMF 19.36.1. */
static double carlson_rf(double x, double y, double z)
{
    for (;;) {
        double mean = (x + y + z) / 3.0;
        double dx = 1.0 - x / mean, dy = 1.0 - y / mean, dz = 1.0 - z / mean;
        if (fmax(fabs(dx), fmax(fabs(dy), fabs(dz))) < 0.008) {
            double e2 = dx * dy - dz * dz, e3 = dx * dy * dz;
            double series = 1.0 + e2 * (-1.0 / 10.0 + e2 / 24.0 - e2 * e2 * (5.0 / 208.0) - e3 * (3.0 / 44.0))
                            + e3 * (1.0 / 14.0 + e3 * (3.0 / 104.0) + e2 * e2 / 16.0);
            return series / sqrt(mean);
        }
        double rx = sqrt(x), ry = sqrt(y), rz = sqrt(z);
        double shift = rx * ry + ry * rz + rz * rx;
        x = 0.25 * (x + shift);
        y = 0.25 * (y + shift);
        z = 0.25 * (z + shift);
    }
}
