"""What the checks of a verdict hold their figures against."""

from axisid.codegen.thresholds.threshold import Threshold

# Levels of tests

CONTRADICTION_LEVEL = Threshold(
    0.01,
    "1",
    "level at which a test says that least squares is biased, or what was fixed contradicted",
    "convention",
)

MAX_FROM_NOMINAL = Threshold(
    5.0,
    "1",
    "factor from a parameter's nominal value, whole interval, from which its value is remarked",
    "chosen: units are apart by 6.28, 9.81, 57.3 or powers of ten",
)

# Control law, force and limit

MAX_LAW_RESIDUAL = Threshold(
    5.0,
    "%",
    "part of the recorded control that a law may leave unexplained",
    "chosen: it is 0.24 % on the EMPS record",
)
MAX_SCALE_ERROR = Threshold(
    0.01,
    "1",
    "distance of a factor from 1, where all else fits, beyond which a column is scaled wrongly",
    "chosen",
)
MIN_UNEVEN = Threshold(
    1e-6,
    "periods",
    "distance of a sample from even times from which on a law that does not fit may have read "
    "something else than the samples",
    "chosen: rounding is below it",
)
MAX_OPEN_RATIO = Threshold(
    2.0,
    "1",
    "what a law leaves of the control of a record with jitter, by what noise between its samples "
    "makes, up to which the law cannot be judged",
    "chosen: it is 1.0 where that noise is all",
)
FACTOR_BLUR = Threshold(
    1e-4,
    "1",
    "least deviation of a factor of a law that reads an ideal velocity, which is in no log",
    "measured: up to 2.4e-4 off on twins without noise, 1e-5 to 1e-4 on whole ones",
)
MAX_FACTOR_ERROR = Threshold(
    0.05,
    "1",
    "distance of a factor of a law that does not fit from a round one, beyond which it is off",
    "chosen",
)
MAX_ONE_GAIN_ERROR = Threshold(
    0.25,
    "1",
    "distance from 1 of the factors that one wrong gain leaves, by its own, up to which it is "
    "named",
    "chosen",
)
MIN_GAIN_TOLD_APART = Threshold(
    1e-4,
    "1",
    "what a gain changes of a control, by that control, and by what the other gains do not change "
    "of it, below which nothing is said of that gain",
    "chosen",
)
MAX_ROUNDED_SHARE = Threshold(
    0.1,
    "1",
    "part of what a gain changes of a control that may be what the log rounds, above which nothing "
    "is said of that gain",
    "derived: its estimate would be low by the square of it, 1 %",
)
MAX_SAME_RESIDUAL = Threshold(
    1.1,
    "1",
    "what a law with one gain changed leaves, by that with another, up to which the record does "
    "not tell which it is",
    "chosen",
)
MAX_CONTROL_LEAN = Threshold(
    0.01,
    "1",
    "constant, or half of a drift, that the recorded control has beside its law, as a share of its "
    "root mean square",
    "chosen",
)
MAX_REPAIRED_RESIDUAL = Threshold(
    0.5,
    "1",
    "residual of a law with changed columns, by the declared one's, below which the change is told",
    "chosen",
)
MAX_EXPLAINED_RESIDUAL = Threshold(
    0.7,
    "1",
    "residual of a law with a shift or a constant, by that without, up to which it is told",
    "chosen",
)
COMPARISON_CUTOFF = Threshold(
    0.02,
    "1",
    "cut-off of what is compared, by the sampling frequency: a law's velocity, force and control",
    "chosen",
)
MAX_FORCE_CUTOFF = Threshold(
    30.0,
    "Hz",
    "cut-off up to which a force and a control are compared",
    "chosen: far below the bandwidth of any current loop",
)
MAX_FORCE_DIFFERENCE = Threshold(
    20.0,
    "%",
    "difference of the recorded force from what the drive makes of the control",
    "chosen",
)
MAX_FORCE_OFFSET = Threshold(
    0.01,
    "1",
    "constant between the force column and what the drive makes of the control, as a share of its "
    "root mean square",
    "chosen",
)
MAX_FORCE_LAG = Threshold(
    5e-3,
    "s",
    "lag of the recorded force behind the control",
    "chosen",
)
MAX_LIMIT_EXCESS = Threshold(
    0.02,
    "1",
    "control beyond the drive's limit, as a share of it, up to which it is at the limit",
    "chosen: more than a converter's noise",
)
NEAR_LIMIT = Threshold(
    0.1,
    "1",
    "distance of a recorded control from the drive's limit, as a share of it, up to which a law's "
    "output may have been beyond the limit there",
    "chosen: more than a converter's noise; a right law is the same with more",
)
MAX_LIMIT_EXCESS_SHARE = Threshold(
    1e-3,
    "1",
    "share of the samples at which the control may be beyond the limit",
    "chosen: spikes may be",
)

# Measured velocity and acceleration

MAX_MOTION_FACTOR_ERROR = Threshold(
    0.01,
    "1",
    "distance from 1 of the factor between a measured velocity, or acceleration, and the "
    "derivative of what is measured before it",
    "chosen: friction and inertia are off by as much",
)
MAX_MOTION_DELAY = Threshold(
    0.35,
    "samples",
    "delay of a measured velocity, or acceleration, behind that derivative",
    "chosen: as much as the force may be misaligned",
)
MAX_MOTION_OFFSET = Threshold(
    0.01,
    "1",
    "constant between the two, as a share of the derivative's root mean square",
    "chosen",
)
MAX_MOTION_DIFFERENCE = Threshold(
    30.0,
    "%",
    "what factor, delay and constant leave of a measured velocity, or acceleration, by the size of "
    "the derivative, from which the column is another signal",
    "chosen: noise within the band that is compared is far less",
)

MIN_SAMPLES_PER_FACTOR = Threshold(
    10,
    "samples",
    "samples that are compared for each term of a law, below which it is not checked",
    "chosen",
)
MIN_SETTLING_TIMES = Threshold(
    10,
    "1",
    "samples of a force and a control, by those in which their low-pass settles, below which they "
    "are compared without it",
    "chosen",
)

# Alignment

MAX_MISALIGNMENT = Threshold(
    0.35,
    "samples",
    "distance of the delay that fits best from the one that is used",
    "chosen: rounding by the filter may look like up to 0.15 samples",
)
MAX_DELAY_DISTANCE = Threshold(
    3.0,
    "deviations",
    "the same in deviations of that delay, where this is more",
    "convention: a chance of 0.3 %",
)
MAX_DELAY_DEVIATION = Threshold(
    0.25,
    "samples",
    "deviation of the delay beyond which nothing is said of it",
    "chosen",
)


# Instruments

MIN_FIRST_STAGE_F = Threshold(
    10.0,
    "1",
    "conditional first-stage F from which instruments are not weak",
    "[StaigerStock1997]; conditional as in [SandersonWindmeijer2016]",
)
MAX_BIAS_DISTANCE = Threshold(
    3.0,
    "deviations",
    "distance of least squares from the instruments, in i.i.d. deviations of these",
    "[Brunot2015]",
)
NOTICEABLE_BIAS = Threshold(
    0.1,
    "1",
    "distance of least squares from the instruments, as a share of these, from which a significant "
    "one is worth a warning; of a fit, what factors of the law move a parameter by, as a share of "
    "it, beyond which nothing is believed",
    "chosen",
)
NEGLIGIBLE_BIAS = Threshold(
    0.01,
    "1",
    "the same share, up to which a difference is no more than a note however significant",
    "chosen",
)
MAX_UNSEEN_BIAS = Threshold(
    0.5,
    "deviations",
    "the same distance, significant by a HAC Hausman test, from which a value is said to be moved",
    "derived: from there on a 95 % interval holds the truth in less than 92 % of cases",
)
MAX_BIAS_IN_INTERVAL = Threshold(
    1.96,
    "deviations",
    "the same distance, from which the interval does not hold the instruments' value, and misses",
    "derived: half of a 95 % interval",
)
MIN_GAIN_OF_PRECISION = Threshold(
    3.0,
    "1",
    "how many times the deviation of idm-iv, beyond 1 % of the value, is that of didim from which "
    "on didim is said to be worth more",
    "chosen: it is 2 where the filter suits, 20 with an encoder of 10 um under the paper's "
    "inappropriate filter",
)
MAX_IDENTITY_ERROR = Threshold(
    1e-6,
    "1",
    "relative distance of the two inertias of least squares, by each other, from r^2",
    "chosen: the two are algebraically one",
)

# Excitation and precision

MAX_VARIANCE_INFLATION = Threshold(
    10.0,
    "1",
    "variance inflation from which a column nearly repeats others",
    "convention",
)
MIN_REPETITION_WEIGHT = Threshold(
    0.3,
    "1",
    "weight of another column in such a repetition, as a share of the largest, from which it is "
    "named",
    "chosen",
)
MIN_ACCELERATION_SHARE = Threshold(
    0.05,
    "1",
    "share of the force below which a term that takes acceleration says that there is hardly any",
    "chosen",
)
MIN_POSITION_VARIATION = Threshold(
    0.1,
    "1",
    "relative variation of a column that depends on the position, below which the axis hardly "
    "leaves its place",
    "chosen",
)
MAX_RELATIVE_DEVIATION = Threshold(
    30.0,
    "%",
    "relative deviation of a parameter up to which it is known",
    "chosen",
)
NEGLIGIBLE_FORCE = Threshold(
    0.01,
    "1",
    "share of the force below which a part of it does not matter: a parameter's, a constant",
    "chosen",
)
NO_DELAY = Threshold(
    0.2,
    "1",
    "share of a drive's declared delay and lag that the record leaves, below which none is there",
    "chosen",
)
NEGLIGIBLE_PEAK_FORCE = Threshold(
    0.05,
    "1",
    "the same anywhere along the record, as a share of the largest force",
    "chosen",
)
NEGLIGIBLE_SIZE = Threshold(
    0.1,
    "1",
    "size of a vague parameter, in what force and motion make of its unit, below which it is small",
    "chosen",
)

# Filter, simulation and residuals

MAX_FILTER_BIAS = Threshold(
    1.0,
    "deviations",
    "the bias of filter and noise of a parameter",
    "chosen",
)
MAX_CLOSE_SIMULATION_ERROR = Threshold(
    10.0,
    "%",
    "simulation error below which nothing is said of it",
    "chosen",
)
NEGLIGIBLE_RESIDUAL = Threshold(
    1e-4,
    "1",
    "residuals less the filter's own, by the left side, up to which what they look like is no more "
    "than a note",
    "measured: at most 4e-7 on simulated records without noise, 5e-3 and more on wrong models that "
    "their residuals tell",
)

# Constant force

MAX_GAIN_RATIO = Threshold(
    2.0,
    "1",
    "how many times the declared drive gain an identified one may be, or the other way round; one "
    "beyond that is no gain but a known value of another record",
    "chosen",
)

# Several records

MAX_RECORD_CHANCE = Threshold(
    0.01,
    "1",
    "chance that records of one machine differ as much, over all of them, below which one speaks "
    "against the rest",
    "convention",
)
MIN_RECORD_SHARE = Threshold(
    1.0,
    "%",
    "force that the parameters of a record alone make otherwise than those of all, beyond which it "
    "speaks against the rest",
    "chosen: as of a frozen estimate on a second record",
)
MIN_COMMON_WORDS = Threshold(
    25,
    "1",
    "runs of eight samples, each once in either record and equally far apart, from which on two "
    "records have samples in common",
    "chosen: other records have none, whose control or position is noisy",
)
MIN_STEPS_OF_TRAVEL = Threshold(
    64,
    "1",
    "steps of a logged position in the whole motion, below which they are no noise to first order",
    "measured: a log of 32 steps moved a cubic stiffness by 22 %, six deviations, of which as much "
    "noise again told nothing",
)
MIN_COMMON_SAMPLES = Threshold(
    0.99,
    "1",
    "part of the samples between the first and the last of these that has to be the same",
    "chosen: runs of one motion before a coarse encoder have others between",
)
MAX_WRITTEN_APART = Threshold(
    1e-6,
    "1",
    "difference of two numbers, by the column's largest, up to which they are one, written with "
    "other digits or in another unit",
    "chosen: files have six digits or more",
)
MAX_REPEATED_SAMPLES = Threshold(
    1.02,
    "1",
    "how often a sample is among the records, on average, beyond which deviations are told too "
    "small",
    "derived: deviations 1 % too small",
)
