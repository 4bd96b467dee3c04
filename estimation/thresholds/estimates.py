"""When an iteration has converged, an estimate can be believed, and a parameter is there at all."""

from axisid.codegen.thresholds.threshold import Threshold

# Simulated loop

MAX_SIMULATION_ERROR = Threshold(
    50.0,
    "%",
    "simulation error from which the simulated loop does not follow the record",
    "chosen: the loop then explains three quarters of the force's power",
)
NO_RELATION = Threshold(
    100.0,
    "%",
    "error, of the simulation or of the equation, from which it explains nothing of the record",
    "derived: nothing of the force's power is explained",
)
MAX_SIMULATION_ERROR_RATIO = Threshold(
    2.0,
    "1",
    "simulation error at the end of the instruments' iteration, by that of least squares, beyond "
    "which a nonlinear model has gone to another solution",
    "chosen",
)

# Convergence

CONVERGED = Threshold(
    1e-2,
    "deviations",
    "step of the instruments' iteration up to which it has converged",
    "chosen",
)
LEAST_SHARE_OF_A_STEP = Threshold(
    0.25,
    "of a parameter",
    "what a step of output error leaves of it where the simulated loop does not follow the record",
    "measured: from 5 to 1000 kg on the EMPS record, with 0.1 to 0.5 alike",
)
MAX_ERROR_GROWTH = Threshold(
    1e-3,
    "of the simulation error",
    "growth of it up to which a step of output error is not halved",
    "chosen: the rounding of a loop's reversals is less",
)
NEARLY_CONVERGED = Threshold(
    0.1,
    "deviations",
    "the same where the simulated loop jumps too much for that",
    "chosen: a hundredth of the variance",
)
BOUND_TOLERANCE = Threshold(
    1e-6,
    "1",
    "relative distance of a nonlinear parameter from a bound up to which it is at the bound",
    "chosen",
)

# Uncertainty

INTERVAL_LEVEL = Threshold(
    0.95,
    "1",
    "probability of the intervals that are printed",
    "convention",
)
MIN_PRINTED_FILTER_BIAS = Threshold(
    0.5,
    "deviations",
    "bias of a parameter from which the value without it is printed",
    "chosen",
)
MAX_CURVATURE = Threshold(
    0.1,
    "1",
    "second-order part of a deviation, by the first, beyond which the delta method is not enough",
    "chosen",
)
MIN_ROWS_PER_PARAMETER = Threshold(
    10,
    "rows",
    "rows for each parameter, or that tell of one, below which deviations cannot be believed",
    "chosen",
)

# What a record shows

MIN_DISTANCE_FROM_NOISE = Threshold(
    3.0,
    "deviations",
    "size from which something stands out of the noise: a parameter, a factor, a constant",
    "convention",
)
MAX_CANCELLED_FORCE = Threshold(
    10.0,
    "1",
    "force that a parameter would have to make to stand out of the noise, times the largest of the "
    "record, beyond which the record does not show it",
    "chosen: other terms may cancel a term",
)
MAX_TIMES_DECLARED = Threshold(
    1e3,
    "1",
    "value that a parameter would have to have, times the one that was declared, beyond which the "
    "record does not show it",
    "chosen",
)
MAX_TIMES_UNIT = Threshold(
    1e9,
    "1",
    "the same, times what force and motion make of its unit, where nothing was declared",
    "chosen: the unit's size is a guess",
)

# Physical parameters from base parameters

MAX_EXACT_DISTANCE = Threshold(
    1e-6,
    "deviations^2",
    "square of the distance of physical parameters from the estimate up to which they reproduce it",
    "chosen",
)
SAME_DISTANCE = Threshold(
    1e-6,
    "1",
    "difference of two such squares, by one more than the lesser, up to which both fit as well",
    "chosen",
)
SAME_PARAMETER = Threshold(
    1e-3,
    "1",
    "difference of two values of a parameter, by its size and deviation, up to which they are one",
    "chosen",
)
MIN_SENSITIVITY = Threshold(
    1e-9,
    "1",
    "smallest singular value of the scaled map to the base parameters, by the largest, below which "
    "the physical parameters do not follow from them",
    "chosen",
)
MIN_NOISE_RATIO = Threshold(
    1e-6,
    "1",
    "noise of a record, by the largest of several, below which records are not weighted by noise",
    "chosen: of a record without noise it is rounding, which tells nothing of its worth",
)
MAX_TIMING_STEP = Threshold(
    0.05,
    "1",
    "step of an estimate of a drive's lag or delay over its deviation, below which it has settled",
    "chosen",
)
LIGHT_ROW = Threshold(
    0.5,
    "1",
    "weight under a loss that is not of squares, below which a row is counted and marked",
    "convention",
)
MEDIAN_OF_NORMAL = Threshold(
    0.6744897501960817,
    "deviations",
    "median size of normal noise, by which a deviation is told from a median",
    "derived: 0.75 quantile of the normal distribution",
)
HUBER_TUNING = Threshold(
    1.345,
    "deviations",
    "size from which Huber's loss no longer counts a residual by its square",
    "95 % as precise as least squares where noise is normal [Huber1981]",
)
BISQUARE_TUNING = Threshold(
    4.685,
    "deviations",
    "size from which the bisquare does not count a residual at all",
    "95 % as precise as least squares where noise is normal [HollandWelsch1977]",
)
