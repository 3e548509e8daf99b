"""`python -m ulna.stability rigid-body [--quick] [--out DIR]`."""

import typer

from .command import stability

typer.run(stability)
