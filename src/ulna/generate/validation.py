"""What a `unit.toml` may say: rules as a table, each with the words that tell what is wrong."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .declaration import Declaration, Variable

REQUIRED = ("name", "description", "kinds", "sources")
OPTIONAL = (
    "events",
    "workspace",
    "resources",
    "directional_derivatives",
    "default_experiment",
    "enumeration",
    "terminal",
)
KINDS = ("co-simulation", "model-exchange")
TYPES = ("Float64", "Float32", "Int32", "UInt64", "Boolean", "Enumeration", "Binary", "Clock")
INTERVALS = ("triggered", "countdown")
VARIABILITIES = ("constant", "fixed", "tunable", "discrete", "continuous")
C_KEYWORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long real "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "bool true false".split()
)


def one_of(what: str, value: object, known: object) -> None:
    """Raises ValueError, with all that is known, unless `value` is among it."""
    if value not in known:
        raise ValueError(f"{what} {value!r} is none of {', '.join(map(str, known))}")


def check_keys(raw: dict, sections: object) -> None:
    """Raises ValueError for a top-level key that is missing, empty or unknown."""
    for key in REQUIRED:
        if not raw.get(key):
            raise ValueError(f"{key} is missing or empty")
    for key in raw:
        one_of("key", key, (*REQUIRED, *OPTIONAL, *sections))
    for kind in raw["kinds"]:
        one_of("kind", kind, KINDS)


def _numbers(v: "Variable") -> list[float]:
    return [x for x in (*(v.start or ()), v.min, v.max) if x is not None]


def _outside(v: "Variable") -> bool:
    low, high = -float("inf") if v.min is None else v.min, float("inf") if v.max is None else v.max
    return any(not low <= x <= high for x in v.start or ())


# Each rule: true where the variable is wrong, and what is wrong with it.
RULES: tuple[tuple[Callable[["Variable"], bool], str], ...] = (
    (lambda v: not v.name.isidentifier() or v.name in C_KEYWORDS, "has a name that cannot be a field in C"),
    (lambda v: v.visible and not v.description, "has no description"),
    (
        lambda v: v.sized and v.causality != "input",
        "has a dimension that is a structural parameter: only a stream or an input may",
    ),
    (lambda v: len(v.extents) > 1, "has more than one dimension that is a structural parameter"),
    (lambda v: v.sized and any(v.start or ()), "has a size that can change, and so starts at zero"),
    (lambda v: any(isinstance(n, int) and n < 1 for n in v.size), "has a dimension below 1"),
    (lambda v: v.type == "Binary" and not v.stream, "is Binary, but no stream"),
    (lambda v: v.type == "Clock" and (v.causality != "input" or bool(v.size)), "is a Clock, but no scalar input"),
    (lambda v: v.type == "Clock" and v.interval not in INTERVALS, f"is a Clock, of no interval of {INTERVALS}"),
    (lambda v: v.type != "Clock" and v.interval is not None, "has an interval, but is no Clock"),
    (lambda v: v.stream and v.causality != "local", "is a stream, but not local"),
    (lambda v: v.state and (v.causality != "output" or v.type != "Float64"), "is a state, but no Float64 output"),
    (lambda v: any(isinstance(x, str) for x in _numbers(v)), "has a start or a limit that is no number"),
    (
        lambda v: v.type in ("Int32", "UInt64") and any(x != int(x) for x in _numbers(v)),
        "has a start or a limit that is no whole number",
    ),
    (lambda v: v.min is not None and v.max is not None and v.min > v.max, "has a min above its max"),
    (lambda v: v.settable and _outside(v), "starts outside its limits"),
)


def check_variable(variable: "Variable") -> None:
    """Raises ValueError for the first rule that a variable breaks."""
    one_of("type", variable.type, TYPES)
    one_of("variability", variable.variability, VARIABILITIES)
    for broken, words in RULES:
        if broken(variable):
            raise ValueError(words)


def problems(declaration: "Declaration") -> Iterator[str]:
    """What does not fit between variables: names used that are not there, or not of the right sort."""
    names: dict[str, Variable] = {}
    for variable in declaration.variables:
        if variable.name in names:
            yield f"{variable.name} is declared twice"
        names[variable.name] = variable
    if declaration.directional_derivatives and declaration.sized:
        yield f"{declaration.sized[0].name} is sized by a structural parameter, which no directional derivative knows"
    for variable in declaration.variables:
        if variable.type == "Clock" and not declaration.events:
            yield f"{variable.name} is a Clock, but the unit has no events"
        for used in variable.depends:
            source = names.get(used.rstrip("@"))
            if source is None or not (source.causality == "input" or source.state):
                yield f"{variable.name} depends on {used!r}, which is no input and no state"
            elif used.endswith("@") and source.count != variable.count:
                yield f"{variable.name} depends on {used!r} element by element, but their sizes differ"
        for terminal in variable.terminal:
            if terminal.split(".")[0] not in declaration.terminals:
                yield f"{variable.name} belongs to {terminal!r}, a terminal not listed"
        for size in variable.extents:
            extent = names.get(size, variable)
            if extent.causality != "structuralParameter":
                yield f"{variable.name} has dimension {size!r}, no structural parameter"
            elif extent.type != "UInt64" or extent.start[0] < 1:
                yield f"{variable.name} has dimension {size!r}, which must be a UInt64 that starts at 1 or more"
            elif variable.sized and extent.max is None:
                yield f"{variable.name} has dimension {size!r}, which must have a max: memory is made for it"
