"""The judge: the units' C held against the textbook on symbols, and the FMUs as built against their C.

`ulna.checks.command.check` is the command; nothing else is imported before it runs, so that the command line works
without CasADi.
"""
