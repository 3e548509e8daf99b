"""UltrasonicSensor from the textbook."""

from .equations import equations
from .identities import identities
from .points import SAMPLES, symbols

__all__ = ["SAMPLES", "equations", "identities", "symbols"]
