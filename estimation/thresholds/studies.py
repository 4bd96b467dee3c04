"""What comparisons, validations and curves of friction are judged by."""

from axisid.codegen.thresholds.threshold import Threshold

EQUAL_ERROR = Threshold(
    1.01,
    "1",
    "held-out error of a model, by the least, up to which it is as good, however precise both are",
    "chosen: it is not worth a parameter",
)
MAX_TIED_ERROR = Threshold(
    1.1,
    "1",
    "the same where the excess is within its standard error",
    "chosen",
)
MIN_TRAINING_ROWS_PER_PARAMETER = Threshold(
    5,
    "rows",
    "rows for each parameter that are left to estimate from, below which no block is held out",
    "chosen",
)
MAX_NESTING_REMAINDER = Threshold(
    1e-8,
    "1",
    "part of a column of the smaller model that the larger one's do not span, up to which it is "
    "nested",
    "chosen",
)
MAX_VALIDATION_ERROR_RATIO = Threshold(
    2.0,
    "1",
    "equation error on another record, by that on the own one, up to which an estimate holds",
    "chosen",
)
MAX_VALIDATION_ERROR = Threshold(
    10.0,
    "%",
    "the same by itself, up to which an estimate holds whatever the other error is",
    "chosen",
)
MAX_VALIDATION_TRACKING = Threshold(
    5.0,
    "%",
    "simulated position from the recorded one, of the tracking error, up to which an estimate "
    "holds whatever it is on its own record",
    "measured: at most 0.7 on right records, 5.4 with a coarse encoder that has as much on its "
    "own; 10 with a gain a tenth off",
)
MAX_REESTIMATE_SHARE = Threshold(
    1.0,
    "%",
    "force that parameters estimated anew make otherwise, up to which the frozen ones hold",
    "measured: a mass a tenth larger makes 2 to 6, right records of 15 s at most 1.3",
)
MIN_REESTIMATE_DISTANCE = Threshold(
    5.5,
    "1",
    "distance of a parameter estimated anew, in deviations, from which it is another one",
    "measured: at most 4 on right records, 5.4 on one of 2 s whose noise lasts 0.5 s; 6.1 and more "
    "with a mass a tenth larger",
)
MAX_KNOWN_SHARE = Threshold(
    0.01,
    "1",
    "part of a second record's samples that the estimates were made from, up to which nothing is "
    "said of it",
    "chosen: windows that touch share a sample",
)
MAX_SWEEP_STEP = Threshold(
    0.1,
    "1",
    "share of its value by which the neighbouring cut-off of a sweep makes a known parameter "
    "another, beyond which none is recommended without instruments",
    "chosen",
)
MIN_SWEPT_CUTOFFS = Threshold(
    3,
    "cut-offs",
    "with an estimate by least squares, below which none is recommended without instruments",
    "derived: one between two others stands still or does not",
)
MAX_HELD_OUT_MOTION = Threshold(
    2.0,
    "1",
    "error of the position in the half of a record that was held out, by the least of a sweep, "
    "beyond which a cut-off is not recommended without instruments",
    "measured: right twins lose no better cut-off by it; beside white noise of the position one is "
    "left out that is biased eight times as much (`benchmarks/sweeps.py`)",
)
MAX_WEIGHT_DEVIATION = Threshold(
    0.02,
    "1",
    "distance of a row's weight from 1 below which it is a point of the friction curve",
    "chosen",
)
MAX_INSEPARABLE_FORCE = Threshold(
    1e-6,
    "1",
    "part of the friction that depends on more than the velocity, up to which there is a curve",
    "chosen",
)
MIN_BIN_ROWS = Threshold(
    4,
    "rows",
    "rows in a bin of velocity from which their mean is shown",
    "chosen",
)
MIN_BIAS = Threshold(
    3.0,
    "1",
    "mean error over the twins of a study, in its standard errors, beyond which it is told as a "
    "bias; of few twins Student's quantile of the same probability",
    "chosen: chance exceeds it in 0.3 % of parameters",
)
FLEET_LEVEL = Threshold(
    0.05,
    "1",
    "probability that one or more of the logs of a fleet stand out though all are alike",
    "convention",
)
MIN_LOGS_PER_PARAMETER = Threshold(
    5,
    "logs",
    "logs for each parameter from which the robust scatter of a fleet tells what is usual",
    "chosen: with fewer, half of them hardly tell a scatter",
)
TREND_LEVEL = Threshold(
    0.05,
    "1",
    "probability that one or more results of a series are beyond their limits though nothing "
    "changes, and the same that a step or a drift is told",
    "convention",
)
MIN_SERIES = Threshold(
    5,
    "results",
    "results of one axis from which the scatter between them tells limits",
    "chosen: with fewer a limit is some ten deviations wide",
)
OTHER_PERIOD = Threshold(
    1e-3,
    "1",
    "difference of a record's sample period from that of a fit's records, from which it may be of "
    "another axis",
    "chosen: clocks agree to less",
)
