"""Saving figures: the same drawing gives the same bytes, and few of them."""

from collections.abc import Iterable
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image


def save(figure: Figure, paths: Iterable[str | Path]) -> None:
    """Writes a figure to each path, .svg with searchable text, .png in a palette of 128 colours."""
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "ulna"}):
        for path in map(Path, paths):
            figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
            if path.suffix == ".png":
                with Image.open(path) as picture:
                    few = picture.convert("RGB").quantize(128, dither=Image.Dither.NONE)
                few.save(path, optimize=True)
