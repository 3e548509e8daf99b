"""The generated C: the struct of values, the table of variables, and the files that join a unit to the FMI code."""

import math

from .declaration import Declaration, Variable

C_TYPES = {
    "Float64": "real",
    "Float32": "float",
    "Int32": "int32_t",
    "UInt64": "uint64_t",
    "Boolean": "bool",
    "Clock": "bool",
    "Enumeration": "int64_t",
}
NUMBER_TYPES = {
    "Float64": "FLOAT64",
    "Float32": "FLOAT32",
    "Int32": "INT32",
    "UInt64": "UINT64",
    "Boolean": "BOOLEAN",
    "Enumeration": "ENUMERATION",
    "Binary": "BINARY",
    "Clock": "CLOCK",
}
CAUSALITIES = {
    "independent": "INDEPENDENT",
    "structuralParameter": "STRUCTURAL_PARAMETER",
    "parameter": "PARAMETER",
    "input": "INPUT",
    "output": "OUTPUT",
    "local": "LOCAL",
    "memory": "MEMORY",
}
CORE = ("log.c", "resources.c", "life_cycle.c", "access.c", "state.c", "stepping.c", "sensitivity.c")
HEADERS = (
    *("unit.h", "variable.h", "vector.h", "instance.h", "internal_steps.h", "complex_step.h"),
    *("instruction_sets.h", "mechanics_checks.h"),
)
INTERFACE = {
    2: ("access_scalars.c", "fmi2.c", "fmi2_modes.c"),
    3: ("access_arrays.c", "sensitivity_adjoint.c", "fmi3.c", "fmi3_access.c", "fmi3_modes.c", "fmi3_clocks.c"),
}


def _field(variable: Variable) -> str:
    if variable.type == "Float64" and variable.size == (4,):
        return f"Quaternion {variable.field};"
    if variable.type == "Float64" and variable.size == (3,):
        return f"Vector {variable.field};"
    extent = f"[{variable.count}]" if variable.size else ""
    return f"{C_TYPES[variable.type]} {variable.field}{extent};"


def _elements(variable: Variable) -> list[str]:
    """The numbers of a field, as C names them."""
    if not variable.size:
        return [variable.field]
    names = {(3,): ".x .y .z", (4,): ".w .x .y .z"}.get(variable.size)
    return [variable.field + name for name in (names.split() if names else map("[{}]".format, range(variable.count)))]


def variables_header(unit: Declaration) -> str:
    """`variables.h`: the struct, one field a variable, and the enumerations."""
    upper = unit.snake.upper()
    lines = [
        f"/* {unit.name}: its values, generated from unit.toml. */",
        f"#ifndef {upper}_VARIABLES_H",
        f"#define {upper}_VARIABLES_H",
        "",
        "#include <stdbool.h>",
        "#include <stddef.h>",
        "#include <stdint.h>",
        "",
        '#include "vector.h"',
        "",
        f"typedef struct {unit.name} {{",
    ]
    for v in unit.variables:
        if not v.stream and not v.sized:
            note = f"{v.description} [{v.unit}]" if v.type == "Float64" else v.description
            lines.append(f"    {_field(v)} /* {note.strip()} */")
    lines += [f"}} {unit.name};", ""]
    for name, entries in unit.enumerations.items():
        prefix = f"{upper}_{name.upper()}"
        lines.append(f"typedef enum {unit.name}{name}Kind {{")
        lines += [f"    {prefix}_{entry.upper()} = {i}," for i, entry in enumerate(entries, 1)]
        lines += [f"}} {unit.name}{name}Kind;", ""]
    lines.append("/* Places in the table of variables. */")
    lines.append("enum {")
    lines += [f"    {upper}_{v.field.upper()} = {i}," for i, v in enumerate(unit.variables)]
    lines += ["};", "", *_arrays(unit), "#endif", ""]
    return "\n".join(lines)


def _arrays(unit: Declaration) -> list[str]:
    """Where the arrays lie that structural parameters size: behind the struct, each at a multiple of 8 bytes."""
    if not unit.sized:
        return []
    lines = [
        "/* Where an array lies that a structural parameter sizes, bytes from the struct; else where they all end. */",
        f"static inline size_t {unit.snake}_array(const {unit.name} *values, size_t variable)",
        "{",
        "    size_t place = (sizeof *values + 7) / 8 * 8;",
    ]
    for v in unit.sized:
        lines += [
            f"    if (variable == {unit.snake.upper()}_{v.field.upper()}) {{",
            "        return place;",
            "    }",
            f"    place += ({v.count} * (size_t)values->{v.extents[0]} * sizeof({C_TYPES[v.type]}) + 7) / 8 * 8;",
        ]
    lines += ["    return place;", "}", ""]
    for v in unit.sized:
        size = " x ".join(map(str, v.size))
        lines += [
            f"/* {v.description} [{v.unit}]: {size} */",
            f"static inline const {C_TYPES[v.type]} *{unit.snake}_{v.field}(const {unit.name} *values)",
            "{",
            f"    size_t place = {unit.snake}_array(values, {unit.snake.upper()}_{v.field.upper()});",
            f"    return (const {C_TYPES[v.type]} *)(const void *)((const char *)values + place);",
            "}",
            "",
        ]
    return lines


def _number(value: float) -> str:
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value))


def _limits(unit: Declaration, v: Variable) -> tuple[float, float]:
    if v.enumeration:
        return 1, len(unit.enumerations[v.enumeration])
    return -math.inf if v.min is None else v.min, math.inf if v.max is None else v.max


def _row(unit: Declaration, v: Variable, places: dict[str, int]) -> str:
    group = "STREAM" if v.stream else str(unit.groups.index(v.group)) if v.group else "NO_GROUP"
    minimum, maximum = _limits(unit, v)
    cells = [
        f'"{v.name}"',
        f'"{v.unit}"',
        NUMBER_TYPES[v.type],
        CAUSALITIES[v.causality],
        v.variability.upper(),
        group,
        str(places[v.rate]) if v.rate else "NO_VARIABLE",
        str(v.quaternion).lower(),
        str(v.state).lower(),
        str(v.interval == "countdown").lower(),
        "0" if v.stream or v.sized else f"offsetof({unit.name}, {v.field})",
        str(v.reference),
        str(v.count),
        f"offsetof({unit.name}, {v.extents[0]})" if v.extents else "0",
        _number(minimum),
        _number(maximum),
        _number(v.nominal if v.nominal is not None else 1.0),
    ]
    return "    {" + ", ".join(cells) + "},"


def table(unit: Declaration) -> str:
    """`table.h`: one row a variable and one function a group, on whatever `real` is."""
    places = {v.name: i for i, v in enumerate(unit.variables)}
    workspace = ", workspace" if unit.workspace else ""
    lines = [
        f"/* {unit.name}: its table of variables, generated from unit.toml. */",
        "static const Variable variables[] = {",
        *[_row(unit, v, places) for v in unit.variables],
        "};",
        "",
    ]
    for group in unit.groups:
        lines += [
            f"static void evaluate_{group}(void *values, const void *workspace)",
            "{",
            "    (void)workspace;",
            f"    {unit.snake}_{group}(values{workspace});",
            "}",
            "",
        ]
    names = [f"evaluate_{group}" for group in unit.groups] or ["0"]
    lines += [
        "static void (*const evaluate[])(void *values, const void *workspace) = {" + ", ".join(names) + "};",
        "",
        "static void initialize(void *values)",
        "{",
        f"    {unit.snake}_initialize(values);",
        "}",
        "",
    ]
    return "\n".join(lines)


def _literal(value: float | bool, kind: str) -> str:
    if kind in ("Boolean", "Clock"):
        return str(bool(value)).lower()
    return _number(value) if kind in ("Float64", "Float32") else str(int(value))


def _initial(v: Variable) -> str:
    values = ", ".join(_literal(x, v.type) for x in v.start or ())
    return f"    .{v.field} = {{{values}}}," if v.size else f"    .{v.field} = {values},"


def _wrappers(unit: Declaration) -> tuple[list[str], dict[str, str]]:
    """Functions on `void *` around those of the unit, and the members of `Unit` that they fill."""
    mine, typed = unit.snake, unit.name
    signatures = {
        "check": ("Status", "const void *values, Log *log", f"return {mine}_check(values, log);"),
        "step": ("Status", "void *values, double step, Log *log", f"return {mine}_step(values, step, log);"),
    }
    if unit.events:
        signatures |= {
            "next_event": ("double", "const void *values", f"return {mine}_next_event(values);"),
            "event": ("void", "void *values", f"{mine}_event(values);"),
        }
    clocks = [v for v in unit.variables if v.type == "Clock"]
    if clocks:
        text = [f"{typed} *all = values;", *(f"all->{v.field} = false;" for v in clocks)]
        signatures["deactivate_clocks"] = ("void", "void *values", "\n    ".join(text))
    if any(v.interval == "countdown" for v in clocks):
        arguments = "const void *values, size_t clock"
        signatures["clock_time"] = ("double", arguments, f"return {mine}_clock_time(values, clock);")
    if unit.workspace:
        signatures |= {
            "workspace_size": ("size_t", "const void *values", f"return {mine}_workspace_size(values);"),
            "prepare": (
                "Status",
                "const void *values, const char *resources, void *workspace, Log *log",
                f"return {mine}_prepare(values, resources, workspace, log);",
            ),
        }
    if unit.resources:
        arguments = "void *values, const char *resources, Log *log"
        signatures["start_from"] = ("Status", arguments, f"return {mine}_start(values, resources, log);")
    if unit.sized:
        signatures["array"] = (
            "size_t",
            "const void *values, size_t variable",
            f"return {mine}_array(values, variable);",
        )
    if any(v.stream for v in unit.variables):
        signatures["stream"] = (
            "void",
            "const void *values, const void *workspace, size_t variable, void *destination",
            f"{mine}_stream(values, workspace, variable, destination);",
        )
    if any(v.state for v in unit.variables):
        sums = [" + ".join(f"all->{place}" for place in _elements(v)) for v in unit.variables if v.state]
        text = [f"const {typed} *all = values;", "double sum = 0.0;", *(f"sum += {s};" for s in sums), "return sum;"]
        signatures["state_sum"] = ("double", "const void *values", "\n    ".join(text))
    lines = [f"/* The functions of {typed} on untyped memory. */"]
    for member, (result, arguments, body) in signatures.items():
        lines += [f"static {result} unit_{member}({arguments})", "{", f"    {body}", "}", ""]
    return lines, {member: f"unit_{member}" for member in signatures}


def unit_source(unit: Declaration, version: int, token: str) -> str:
    """`fmu.c`: all of an FMU in one translation unit, so that nothing but the FMI functions is visible outside."""
    wrappers, members = _wrappers(unit)
    scalars = [i for i, v in enumerate(unit.variables) for _ in range(v.scalars)]
    if unit.directional_derivatives:
        members["directional"] = f"{unit.snake}_directional"
    lines = [
        f"/* {unit.name} for FMI {version}.0: the whole FMU as one translation unit; generated from unit.toml. */",
    ]
    if version == 3:
        lines.append(f"#define FMI3_FUNCTION_PREFIX {unit.name}_")
    lines += [
        "#include <math.h>",
        "#include <stddef.h>",
        "",
        '#include "unit.c"',
        '#include "table.h"',
        "",
        *wrappers,
    ]
    if unit.directional_derivatives:
        lines += [
            f"void {unit.snake}_directional(const double *values, const void *workspace, bool initializing,",
            "    uint32_t groups, const double *seed, double *sensitivity);",
            "",
        ]
    lines += [
        "static const uint16_t variable_of[] = {",
        *["    " + ", ".join(map(str, scalars[i : i + 24])) + "," for i in range(0, len(scalars), 24)],
        "};",
        "",
        "static const uint16_t state_variables[] = {",
        "    " + ", ".join([str(i) for i, v in enumerate(unit.variables) if v.state] or ["0"]) + ",",
        "};",
        "",
        f"static const {unit.name} start_values = {{",
        *[_initial(v) for v in unit.variables if not v.stream and not v.sized],
        "};",
        "",
        "static const Unit unit = {",
        f'    .name = "{unit.name}",',
        f'    .token = "{token}",',
        "    .variables = variables,",
        f"    .variable_count = {len(unit.variables)},",
        "    .variable_of = variable_of,",
        f"    .reference_count = {len(scalars)},",
        "    .states = state_variables,",
        f"    .state_variables = {sum(v.state for v in unit.variables)},",
        f"    .state_count = {sum(v.count for v in unit.variables if v.state)},",
        f"    .size = sizeof({unit.name}),",
        "    .start = &start_values,",
        f"    .group_count = {len(unit.groups)},",
        "    .evaluate = evaluate,",
        "    .initialize = initialize,",
        *[f"    .{member} = {function}," for member, function in members.items()],
        "};",
        "",
        *[f'#include "{file}"' for file in CORE + INTERFACE[version]],
        "",
    ]
    return "\n".join(lines)


def directional_source(unit: Declaration) -> str:
    """`complex.c`: the unit's equations once more, on complex numbers, for its directional derivatives."""
    return "\n".join(
        [
            f"/* {unit.name}: its equations on complex numbers, for directional derivatives; generated. */",
            "#define real double _Complex",
            "#include <complex.h>",
            "#include <math.h>",
            "#include <stddef.h>",
            "",
            '#include "variable.h"',
            '#include "equations.h"',
            '#include "table.h"',
            "",
            f"typedef {unit.name} ComplexValues;",
            f"#define DIRECTIONAL {unit.snake}_directional",
            '#include "complex_step.h"',
            "",
        ]
    )
