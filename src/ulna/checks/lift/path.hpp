// The number type with which C that branches is traced: a symbol, and the value that decides where a branch goes.
// What is traced is the formula of the path that is taken at these values, loops unrolled.
#ifndef ULNA_PATH_HPP
#define ULNA_PATH_HPP

#include "lift.hpp"

#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <math.h>
#include <type_traits>

struct Path {
    Real symbol;
    double value;

    Path() : value(0.0) {}
    Path(const Real &symbol, double value) : symbol(symbol), value(value) {}
    template <class Number, class = std::enable_if_t<std::is_arithmetic<Number>::value || std::is_enum<Number>::value>>
    Path(Number number) : symbol(static_cast<double>(number)), value(static_cast<double>(number)) {}

    explicit operator int() const { return static_cast<int>(value); }
    Path operator-() const { return {-symbol, -value}; }
    Path &operator+=(const Path &b);
    Path &operator-=(const Path &b);
    Path &operator*=(const Path &b);
};

inline Path operator+(const Path &a, const Path &b) { return {a.symbol + b.symbol, a.value + b.value}; }
inline Path operator-(const Path &a, const Path &b) { return {a.symbol - b.symbol, a.value - b.value}; }
inline Path operator*(const Path &a, const Path &b) { return {a.symbol * b.symbol, a.value * b.value}; }
inline Path operator/(const Path &a, const Path &b) { return {a.symbol / b.symbol, a.value / b.value}; }
inline Path &Path::operator+=(const Path &b) { return *this = *this + b; }
inline Path &Path::operator-=(const Path &b) { return *this = *this - b; }
inline Path &Path::operator*=(const Path &b) { return *this = *this * b; }

inline bool operator<(const Path &a, const Path &b) { return a.value < b.value; }
inline bool operator>(const Path &a, const Path &b) { return a.value > b.value; }
inline bool operator<=(const Path &a, const Path &b) { return a.value <= b.value; }
inline bool operator>=(const Path &a, const Path &b) { return a.value >= b.value; }
inline bool operator==(const Path &a, const Path &b) { return a.value == b.value; }
inline bool operator!=(const Path &a, const Path &b) { return a.value != b.value; }

inline Path sqrt(const Path &a) { return {sqrt(a.symbol), std::sqrt(a.value)}; }
inline Path sin(const Path &a) { return {sin(a.symbol), std::sin(a.value)}; }
inline Path cos(const Path &a) { return {cos(a.symbol), std::cos(a.value)}; }
inline Path exp(const Path &a) { return {exp(a.symbol), std::exp(a.value)}; }
inline Path log(const Path &a) { return {log(a.symbol), std::log(a.value)}; }
inline Path pow(const Path &a, const Path &b) { return {pow(a.symbol, b.symbol), std::pow(a.value, b.value)}; }
inline Path cbrt(const Path &a) { return {pow(a.symbol, Real(1.0 / 3.0)), std::cbrt(a.value)}; }
inline Path hypot(const Path &a, const Path &b) { return sqrt(a * a + b * b); }
// a product that is not rounded: here none is
inline Path fma(const Path &a, const Path &b, const Path &c)
{
    return {a.symbol * b.symbol + c.symbol, std::fma(a.value, b.value, c.value)};
}

inline Path fabs(const Path &a) { return a.value < 0.0 ? -a : a; }
inline Path copysign(const Path &a, const Path &b) { return std::signbit(b.value) ? -fabs(a) : fabs(a); }
inline Path fmin(const Path &a, const Path &b) { return a.value < b.value ? a : b; }
inline Path fmax(const Path &a, const Path &b) { return a.value > b.value ? a : b; }
inline Path floor(const Path &a) { return std::floor(a.value); }
inline Path ceil(const Path &a) { return std::ceil(a.value); }
inline bool isfinite(const Path &a) { return std::isfinite(a.value); }

// The elements of a number, a vector, a quaternion or an array of numbers.
#define PATHS(field) reinterpret_cast<Path *>(&(field)), sizeof(field) / sizeof(Path)

// One step in the making: inputs are symbols with a value.
class Trace : public Lift {
public:
    void value(const std::string &name, Path *elements, size_t count, std::initializer_list<double> values)
    {
        std::vector<Real> symbols(count);
        input(name, symbols.data(), count);
        for (size_t i = 0; i < count; i++) {
            elements[i] = Path(symbols[i], values.begin()[i]);
        }
    }

    void result(const std::string &name, const Path *elements, size_t count)
    {
        std::vector<Real> symbols;
        for (size_t i = 0; i < count; i++) {
            symbols.push_back(elements[i].symbol);
        }
        output(name, symbols.data(), count);
    }
};

#endif
