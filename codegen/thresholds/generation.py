"""What is generated against the declaration."""

from .threshold import Threshold

MAX_CONTROL_DIFFERENCE = Threshold(
    1e-9,
    "1",
    "difference of a control from what a drive's inverse makes of its force, as a share of the "
    "largest control, up to which the inverse undoes the force",
    "chosen: an inverse may cancel",
)
