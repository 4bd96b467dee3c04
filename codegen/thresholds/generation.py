"""What is generated against the declaration."""

from .threshold import Threshold

MAX_CONTROL_DIFFERENCE = Threshold(
    1e-9,
    "1",
    "difference of a control from what a drive's inverse makes of its force, as a share of the "
    "largest control, up to which the inverse undoes the force",
    "chosen: an inverse may cancel",
)
MAX_GAIN_SLOPE_DIFFERENCE = Threshold(
    1e-5,
    "1",
    "difference of a drive's slope by its gain from what other gains change, as a share of the "
    "largest force or slope",
    "chosen: a difference of gains is right to second order, 1e-8",
)
MAX_DECLARED_ROUNDING = Threshold(
    1e3,
    "1",
    "distance of a program from the declared force, by the rounding of that in double precision, "
    "up to which rounding explains it",
    "chosen",
)
MAX_SUMMED_DIFFERENCE = Threshold(
    1e-12,
    "1",
    "the same by the sizes of the columns that are added up, which may cancel",
    "chosen: some thousand roundings of a double",
)
