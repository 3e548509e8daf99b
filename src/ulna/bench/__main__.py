"""`python -m ulna.bench [UNIT ...]` prints the tables of these units, or of all."""

import sys

from . import run, show

try:
    show(run(sys.argv[1:]))
except (KeyError, FileNotFoundError, ModuleNotFoundError) as error:
    sys.exit(str(error.args[0]))
