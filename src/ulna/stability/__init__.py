"""Where the solvers of the rigid bodies, and the masters, fail, measured through the FMUs and set against theory.

`ulna stability rigid-body` or `coupling`, or `python -m ulna.stability` with the same.
"""

from .coupling_measuring import measure_coupling
from .coupling_picture import draw_coupling
from .measuring import measure
from .picture import draw

__all__ = ["draw", "draw_coupling", "measure", "measure_coupling"]
