"""Messages for wrong names."""

from collections.abc import Iterable
from difflib import get_close_matches


def unknown(owner: str, kind: str, name: str, known: Iterable[str]) -> str:
    """The message for a wrong name: it offers the nearest right ones."""
    nearest = get_close_matches(name, known := list(known), n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(nearest)}?" if nearest else f"it has {', '.join(sorted(known)) or 'none'}"
    return f"{owner} has no {kind} {name!r}: {hint}"
