// The number type and the book-keeping with which a unit's C is traced into CasADi functions.
#ifndef ULNA_LIFT_HPP
#define ULNA_LIFT_HPP

#include <casadi/casadi.hpp>

#include <cmath>
#include <string>
#include <vector>

// A symbolic number that starts as zero, as C's {0} says, where CasADi's own starts as not-a-number.
struct Real : casadi::SXElem {
    Real() : casadi::SXElem(0.0) {}
    Real(double value) : casadi::SXElem(value) {}
    Real(const casadi::SXElem &value) : casadi::SXElem(value) {}
};

// The elements of a number, a vector, a quaternion or an array of numbers.
#define REALS(field) reinterpret_cast<Real *>(&(field)), sizeof(field) / sizeof(Real)

// One CasADi function in the making: symbols as inputs, what the C made of them as outputs.
class Lift {
public:
    void input(const std::string &name, Real *elements, size_t count)
    {
        casadi::SX symbols = casadi::SX::sym(name, static_cast<casadi_int>(count));
        inputs.push_back(symbols);
        input_names.push_back(name);
        for (size_t i = 0; i < count; i++) {
            elements[i] = symbols.nonzeros()[i];
        }
    }

    template <class T> T symbols(const std::string &name)
    {
        T value;
        input(name, REALS(value));
        return value;
    }

    void output(const std::string &name, Real *elements, size_t count)
    {
        std::vector<casadi::SXElem> values(elements, elements + count);
        outputs.push_back(casadi::SX(values));
        output_names.push_back("to_" + name);
    }

    template <class T> void output(const std::string &name, T value)
    {
        output(name, REALS(value));
    }

    // Only what the C has written: a field that still is its own symbol is no result.
    void changed(const std::string &name, Real *elements, size_t count)
    {
        const std::vector<casadi::SXElem> &before = inputs[place(name)].nonzeros();
        for (size_t i = 0; i < count; i++) {
            if (!casadi::SXElem::is_equal(before[i], elements[i], 0)) {
                output(name, elements, count);
                return;
            }
        }
    }

    void save(const std::string &name) const
    {
        casadi::Function(name, inputs, outputs, input_names, output_names).save(name + ".casadi");
    }

private:
    size_t place(const std::string &name) const
    {
        size_t i = 0;
        while (input_names[i] != name) {
            i++;
        }
        return i;
    }

    std::vector<casadi::SX> inputs, outputs;
    std::vector<std::string> input_names, output_names;
};

// A function of one result.
template <class F> void lift_function(const std::string &name, F compute)
{
    Lift lift;
    auto value = compute(lift);
    lift.output("value", value);
    lift.save(name);
}

#endif
