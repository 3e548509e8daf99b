"""Where solvers of the rigid bodies, masters, skins and the sensor fail, measured through the FMUs, beside theory.

`ulna stability rigid-body`, `coupling`, `skin` or `sensor`, or `python -m ulna.stability` with the same.
"""

from .coupling_measuring import measure_coupling
from .coupling_picture import draw_coupling
from .measuring import measure
from .picture import draw
from .sensor_measuring import measure_sensor
from .sensor_picture import draw_sensor
from .skin_measuring import measure_skin
from .skin_picture import draw_skin

__all__ = [
    "draw",
    "draw_coupling",
    "draw_sensor",
    "draw_skin",
    "measure",
    "measure_coupling",
    "measure_sensor",
    "measure_skin",
]
