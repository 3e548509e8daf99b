"""From one `unit.toml` to all that the FMI standard wants written about a unit.

Needs nothing beyond Python's standard library, so that the build can run it anywhere.
"""
