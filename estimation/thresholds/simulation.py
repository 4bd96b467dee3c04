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
START_AGREEMENT = Threshold(
    2.5,
    "1",
    "deviations within which the velocity at the start of a record is that of every fit to fewer "
    "samples, so that more are taken",
    "chosen: of 1.5 and 2.5 the one whose velocities err less on twins of the library",
)
MIN_START_DISTANCE = Threshold(
    5.0,
    "1",
    "deviations from rest beyond which a record begins in motion, or with a memory other than that "
    "of an axis at rest",
    "chosen: 540 simulated starts at rest reach 4.1",
)
MIN_START_ERROR = Threshold(
    1e-3,
    "1",
    "part of the recorded control that the law may miss over the first samples with the memory "
    "that is declared for an axis at rest, so that this is taken",
    "chosen: half the 0.24 % that the law leaves of the EMPS record",
)
MIN_PHASE_AGREEMENT = Threshold(
    0.4,
    "1",
    "mean of unit vectors by the phase at which a control changes, from which on a log that is "
    "faster than the law tells when that is evaluated",
    "derived: a log three samples of which fall on two evaluations gives 0.5, chance next to none",
)
MIN_MEMORY_EFFECT = Threshold(
    1e-3,
    "1",
    "effect on the first controls, of the largest that a change of the memory has, below which the "
    "memory stays as declared in that direction",
    "chosen",
)
MAX_START_LEFT = Threshold(
    0.1,
    "1",
    "part of what the law misses of the first controls with the memory of an axis at rest, that it "
    "may miss with another one, so that this is taken",
    "chosen: on twins at rest a wrong gain leaves 0.5 and more; under a load or in motion 0.04 at "
    "most, with gains 10 to 50 % off too",
)
MAX_CLOCK_RATIO = Threshold(
    400.0,
    "1",
    "times that a law's period fits into that of a reference, or the other way round, beyond which "
    "one of them is taken for a mistake",
    "chosen: a loop of 20 kHz logged at 50 Hz; a period in ms is 1000 times too long",
)
