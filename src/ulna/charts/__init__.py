"""Charts of accuracy against speed: `ulna chart rigid-body`, or `python -m ulna.charts rigid-body`."""
