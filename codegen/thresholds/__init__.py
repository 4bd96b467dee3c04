"""The numbers by which generated code is refused: each once, with its unit and its source.

In: nothing. Out: `Threshold` and rows of it; the documentation prints them with those of
`axisid.estimation.thresholds`, which are rows of the same. Knows nothing of who judges by them. Its
modules are imported by name.
"""
