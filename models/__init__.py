"""The units' equations from the textbook, in CasADi: what the C is judged by. Nothing here knows the C.

Each module but `jointed_arm` is named after its unit's folder and offers, on dictionaries from variable name to `SX`
column:

- `symbols()`: the general point at which equations are compared: a free symbol per variable, or an expression in
  free symbols where a variable is bound (an axis of length 1).
- `equations(values)`: outputs by name, derivatives as `der(NAME)`, states at the start as `initial(NAME)`.
- `identities(f)`: expressions that vanish for every value of their symbols, by the claim in words; `f` is `equations`
  or anything that answers like it, such as the C traced on symbols.
- `step_identities(step)`, where there are states: the same of one step of a solver. `step(solver, values, h)` gives
  the states after it; `values["elapsed"]` is how long before the communication step has begun.
- `step_failures(step)`: expressions that do NOT vanish: what a solver is known to lose.
- `SOLVERS`, where there are some: what each declares, as `declared.Solver`: the order of a step by the kind of case,
  and which of the `QUANTITIES` it keeps. `KINDS` has the kinds in words, `CASES` values for each, by the names of the
  symbols of `point()` and the step `h`; `QUANTITIES` pairs a kind with what a step changes of it. `motion(values)` is
  the exact flow as pairs of symbols and rates, `start(values)` the parameters that start a unit there.
- `SAMPLES`: by the name of a symbol, the range in which it is to be drawn; (-1, 1) for all others. Elements of a
  column `x` are the symbols `x_0`, `x_1`, ...

`jointed_arm` is no unit but what coupled units are judged by: chains of bodies on hinges and ball joints.
`ultrasonic_sensor.hearing`, `.echoes` and `.surfaces` are wave theory in NumPy and SciPy: what echoes are judged by.

Functions of a unit that compute no variable of its own (the paths of the sensor, a point of the skin) have their
results by `FUNCTION.RESULT`, or `FUNCTION` if there is one.
"""
