"""`python -m ulna.bench [NAME ...]` prints the tables of these units, of masters, or of all."""

import sys

from . import run, show

try:
    show(run(sys.argv[1:]))
except (KeyError, FileNotFoundError, ModuleNotFoundError) as error:
    sys.exit(str(error.args[0]))
