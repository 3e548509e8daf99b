"""Bodies joined in a chain by hinges and ball joints, in minimal coordinates: what coupled units are judged by.

Plain data in, numbers out; nothing here is a unit.
"""

from .mechanics import Arm, jointed_arm
from .reference import reference

__all__ = ["Arm", "jointed_arm", "reference"]
