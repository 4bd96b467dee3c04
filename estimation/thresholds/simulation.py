"""What a loop may be simulated with, and how far it may go."""

from axisid.codegen.thresholds.threshold import Threshold

RUNAWAY_RATIO = Threshold(
    100.0,
    "1",
    "distance of a simulated loop from its reference, in what it is asked to move, beyond which it "
    "has run away",
    "chosen",
)
MAX_STIFFNESS_RATIO = Threshold(
    16,
    "1",
    "steps that a loop's rates ask for, times the most there are, beyond which it is too stiff",
    "derived: rate times step is then near 1",
)
MAX_WAVE_RATIO = Threshold(
    2,
    "1",
    "the same for the speed at which it passes a wave of the position",
    "derived: Simpson's rule then errs by 2e-5 of the wave",
)
