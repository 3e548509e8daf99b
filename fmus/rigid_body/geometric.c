/* RigidBody: midpoint and discrete Moser-Veselov, both Cayley turns that satisfy an equation.
 *
 * A step turns the body by (1, e) / sqrt(1 + e.e), where with the momentum m in body axes
 *   midpoint          h m / 2           = I e + e x I e,   m_next ~ I e - e x I e
 *   Moser-Veselov     h m (1 + e.e) / 2 = J e + e x J e,   m_next ~ J e - e x J e
 * and both keep the energy of the inertia that they are given, and L. The first is Austin, Krishnaprasad
 * and Wang, J. Comput. Phys. 107 (1993) 105, in e = h w / 2 of the mean momentum; the second, with
 * J of moser_veselov_series.h, Hairer and Vilmart, J. Phys. A 39 (2006) 13225.
 */
#include "equations.h"
#include "moser_veselov_series.h"

typedef struct CayleyTurn {
    Vector e;
    bool found;
} CayleyTurn;

/* Newton's method on half_step (1 + curvature e.e) = I e + e x I e, from one fixed-point step.
 * Not found where the way from e = 0 has left the branch: the determinant is no longer positive. */
static CayleyTurn cayley_turn(Vector inertia, Vector half_step, double curvature)
{
    enum { MOST = 12 };
    const double enough = 1e-17; /* a correction of 3e-9 leaves an error of its square */
    Vector first = divide_elements(half_step, inertia);
    CayleyTurn turn = {subtract(first, divide_elements(cross(first, half_step), inertia)), false};
    for (int i = 0; i < MOST && !turn.found; i++) {
        Vector e = turn.e;
        Vector momentum = multiply_elements(inertia, e);
        Vector excess = add(momentum, cross(e, momentum));
        excess = add_scaled(excess, -1.0 - curvature * dot(e, e), half_step);
        /* columns of the slope of I e + e x I e, and of the rest */
        Vector rest = scale(-2.0 * curvature, half_step);
        Vector x = vector(inertia.x, inertia.x * e.z - momentum.z, momentum.y - inertia.x * e.y);
        Vector y = vector(momentum.z - inertia.y * e.z, inertia.y, inertia.y * e.x - momentum.x);
        Vector z = vector(inertia.z * e.y - momentum.y, momentum.x - inertia.z * e.x, inertia.z);
        x = add_scaled(x, e.x, rest);
        y = add_scaled(y, e.y, rest);
        z = add_scaled(z, e.z, rest);
        Vector yz = cross(y, z);
        double determinant = dot(x, yz);
        Vector correction = vector(dot(excess, yz), dot(excess, cross(z, x)), dot(excess, cross(x, y)));
        correction = scale(1.0 / determinant, correction);
        turn.e = subtract(e, correction);
        turn.found = determinant > 0.0 && dot(correction, correction) <= enough * dot(turn.e, turn.e);
    }
    return turn;
}

static inline Motion turned_by(Motion m, Vector e)
{
    m.orientation = normalized(compose(m.orientation, quaternion(1.0, e.x, e.y, e.z)));
    return m;
}

/* About the middle axis the turn is lost where h times the growth rate of that spin passes 2: then the
 * splitting takes the step, which has nothing to solve. */
static inline Motion midpoint_rotation(const RigidBody *body, Motion m, double h)
{
    Vector momentum = to_body(rotation(m.orientation), m.angular_momentum);
    CayleyTurn turn = cayley_turn(body->inertia, scale(0.5 * h, momentum), 0.0);
    if (!turn.found) {
        m = five_rotations(body, m, h);
        m.beyond_limit = true;
        return m;
    }
    return turned_by(m, turn.e);
}

static Motion midpoint_step(const RigidBody *body, const LinearLoads *loads, Motion m, double elapsed, double h)
{
    return strang_step(body, loads, m, elapsed, h, midpoint_rotation);
}

/* Turns below 90 degrees, where J sin(angle) = h L has its first solution; beyond, the midpoint takes the
 * step, which keeps the energy as well. */
static inline Motion moser_veselov_rotation(const RigidBody *body, Motion m, double h)
{
    const double largest_turn = 1.5; /* rad */
    const double largest_energy = 100.0; /* above, the series' terms cancel each other's digits */
    Vector momentum = to_body(rotation(m.orientation), m.angular_momentum);
    Vector i = divide_elements(vector(1.0, 1.0, 1.0), body->inertia);
    Vector rate = multiply_elements(momentum, i);
    double energy = 0.5 * h * h * dot(momentum, rate), sum = i.x + i.y + i.z;
    InverseInertia inverse = moser_veselov_series(0.5 * h * h * dot(momentum, momentum), energy, sum,
                                                  i.x * i.y + i.y * i.z + i.z * i.x, i.x * i.y * i.z);
    Vector inertia = vector(1.0 / (inverse.factor * i.x + inverse.offset),
                            1.0 / (inverse.factor * i.y + inverse.offset),
                            1.0 / (inverse.factor * i.z + inverse.offset));
    CayleyTurn turn = cayley_turn(inertia, scale(0.5 * h, momentum), 1.0);
    if (!turn.found || h * norm(rate) > largest_turn || energy * sum > largest_energy) {
        m = midpoint_rotation(body, m, h);
        m.beyond_limit = true;
        return m;
    }
    return turned_by(m, turn.e);
}

static Motion moser_veselov_step(const RigidBody *body, const LinearLoads *loads, Motion m, double elapsed, double h)
{
    return strang_step(body, loads, m, elapsed, h, moser_veselov_rotation);
}
