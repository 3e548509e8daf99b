"""`python -m ulna.checks`: the same as `ulna check`."""

import typer

from .command import check

typer.run(check)
