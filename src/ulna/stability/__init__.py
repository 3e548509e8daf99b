"""Where the solvers of the rigid bodies, the masters, and the skins fail, measured through the FMUs, beside theory.

`ulna stability rigid-body`, `coupling` or `skin`, or `python -m ulna.stability` with the same.
"""

from .coupling_measuring import measure_coupling
from .coupling_picture import draw_coupling
from .measuring import measure
from .picture import draw
from .skin_measuring import measure_skin
from .skin_picture import draw_skin

__all__ = ["draw", "draw_coupling", "draw_skin", "measure", "measure_coupling", "measure_skin"]
