"""What is generated against the declaration, and what is compiled against the virtual machine."""

from .threshold import Threshold

# Against the declaration

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

# Against the virtual machine

MAX_FUNCTION_DIFFERENCE = Threshold(
    1e-12,
    "1",
    "difference of a compiled function from the virtual machine's, as a share of its value, beside "
    "what rounding explains, up to which a library is taken",
    "chosen: some thousand roundings of a double",
)
MAX_LOOP_DIFFERENCE = Threshold(
    1e-9,
    "1",
    "difference of a compiled loop's signal from the virtual machine's, as a share of its size",
    "chosen: a few samples magnify rounding",
)
MAX_MAGNIFIED_DIFFERENCE = Threshold(
    1e3,
    "1",
    "the same by what a change of a start and of parameters by 1e-15 moves the signal, where that "
    "is more",
    "chosen",
)
MAX_ROUNDING_SHARE = Threshold(
    1e-9,
    "1",
    "share of a result that rounding may move, beyond which the trial's steps are cut",
    "chosen: more would hide a fault of the code",
)
MAX_TESTED_RATE = Threshold(
    0.25,
    "1",
    "rate of the plant times a step, beyond which the trial's steps are cut",
    "chosen: a Runge-Kutta step resolves it",
)
