"""`python -m ulna.charts rigid-body [--quick] [--out DIR]`."""

import typer

from .command import chart

typer.run(chart)
