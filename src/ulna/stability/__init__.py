"""Where the solvers of the rigid bodies fail, measured through the FMUs and set against theory.

`ulna stability rigid-body`, or `python -m ulna.stability rigid-body`.
"""

from .measuring import measure
from .picture import draw

__all__ = ["draw", "measure"]
