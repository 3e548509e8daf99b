"""The figures of a run that are worth a line on the terminal."""

from collections.abc import Callable

import numpy as np

from .results import Results

Line = tuple[str, str]
"""What, and its value with its unit."""


def summary(results: Results) -> list[Line]:
    """Energies, skin, pings and speed, as far as they were recorded."""
    units = dict.fromkeys(name.split(".")[0] for name in results)
    lines = []
    for unit in units:
        for what, variables, describe in FIGURES:
            columns = [f"{unit}.{variable}" for variable in variables]
            if all(column in results for column in columns):
                lines.append((f"{unit}: {what}", describe(*(results[column] for column in columns))))
    return lines + _coupling(results) + _speed(results)


def _energy(kinetic: np.ndarray, potential: np.ndarray) -> str:
    total = kinetic + potential
    return f"{total[0]:.6g} to {total[-1]:.6g} J, at most {np.abs(total - total[0]).max():.2g} J off the start"


def _angle(angle: np.ndarray) -> str:
    low, high = np.degrees([angle.min(), angle.max()])
    return f"{low:.1f} to {high:.1f} degrees"


def _least(ratio: np.ndarray) -> str:
    return f"{100 * ratio.min():.2f} % of rest"


def _gap(gap: np.ndarray) -> str:
    return f"{1e3 * gap.max():.2f} mm"


def _fold(fraction: np.ndarray) -> str:
    return f"{100 * fraction.max():.2f} %"


def _pings(sequence: np.ndarray, valid: np.ndarray) -> str:
    rows = np.flatnonzero(np.diff(sequence)) + 1
    return f"{sequence[-1]}, of which {np.count_nonzero(valid[rows])} heard an echo"


# What, the variables of one unit that it takes, and how they are told.
FIGURES: tuple[tuple[str, tuple[str, ...], Callable[..., str]], ...] = (
    ("energy", ("kinetic_energy", "potential_energy"), _energy),
    ("elbow", ("angle",), _angle),
    ("volume of the elbow zone", ("blend_volume_ratio",), _least),
    ("least section", ("minimum_section_ratio",), _least),
    ("elbow gap", ("elbow_gap",), _gap),
    ("folded triangles", ("fold_fraction",), _fold),
    ("pings", ("sequence", "valid"), _pings),
)


def _coupling(results: Results) -> list[Line]:
    """What the coupling does wrong, as far as the run could tell."""
    figures, lines = results.summary, []
    if "largest_gap" in figures:
        lines.append(("joints", f"at most {figures['largest_gap']:.2g} m apart"))
    if figures.get("input_error"):
        lines.append(
            ("coupling: error of an input", f"at most {figures['input_error']:.2g}, {figures['input_error_at']}")
        )
    if "coupling_energy" in figures:
        share = abs(figures["coupling_energy"]) / (figures["system_energy"] or 1.0)
        verdict = ": this run is wrong" if figures["wrong"] else ""
        energy = f"{figures['coupling_energy']:.2g} J gained, {100 * share:.2g} % of the system's{verdict}"
        lines.append(("coupling: energy", energy))
    if "macro_steps" in figures:
        steps = (
            f"{figures['macro_steps']}, down to {figures['shortest_step']:.2g} s; {figures['repeated_steps']} repeated"
        )
        lines.append(("macro steps", steps))
    return lines


def _speed(results: Results) -> list[Line]:
    figures = results.summary
    if not figures.get("steps"):
        return []
    speed = f"{figures['real_time_factor']:.1f} x, {1e6 * figures['wall_time'] / figures['steps']:.1f} us a step"
    return [("simulated", f"{np.ptp(results.time):g} s in {figures['steps']} steps"), ("real-time factor", speed)]
