"""`python -m ulna.stability rigid-body|coupling|skin [--quick] [--out DIR]`."""

import typer

from .command import stability

typer.run(stability)
