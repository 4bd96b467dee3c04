"""The numbers by which generated code is refused: each once, with its unit and its source.

In: nothing. Out: rows of `Threshold`; the documentation prints them with those of
`axisid.estimation.thresholds`. Knows nothing of who judges by them.
"""

from axisid.support.threshold import Threshold

MAX_CONTROL_DIFFERENCE = Threshold(
    1e-9,
    "1",
    "difference of a control from what a drive's inverse makes of its force, as a share of the "
    "largest control, up to which the inverse undoes the force",
    "chosen: an inverse may cancel",
)
