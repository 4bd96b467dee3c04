"""What the filter leaves of a record, and what the motion is."""

from axisid.codegen.thresholds.threshold import Threshold

# Motion

REST_SPEED = Threshold(
    1e-3,
    "1",
    "speed, as a share of the largest, below which an axis rests",
    "chosen",
)
MIN_MOVING_SPEED = Threshold(
    0.05,
    "1",
    "speed, as a share of the largest, beyond which an axis moves",
    "chosen",
)
MAX_REST_SPEED = Threshold(
    0.01,
    "1",
    "mean of the speed, as a share of the largest, below which a slow stretch is a rest",
    "chosen: what noise may make of a rest",
)
MIN_REVERSED_SHARE = Threshold(
    0.01,
    "1",
    "share of the samples in motion that go the other way, below which the axis hardly reverses",
    "chosen",
)
MIN_STEADY_SAMPLES = Threshold(
    16,
    "samples",
    "samples at steady speed from which it is told whether there is one speed only",
    "chosen",
)
MIN_SPEED_SPREAD = Threshold(
    0.1,
    "1",
    "relative spread of the cruising speed below which there is one speed only",
    "chosen",
)
MAX_STEADY_ACCELERATION = Threshold(
    0.1,
    "1",
    "acceleration, as a share of the largest, below which the speed is steady",
    "chosen",
)
MAX_REST_SHARE = Threshold(
    0.1,
    "1",
    "share of the samples of the fit at which an axis rests, beyond which that is named as what "
    "keeps a loop from following or an iteration from its end",
    "measured: an eighth moves friction by a tenth, a third by most of it",
)

# Prefilter

MIN_CUTOFF = Threshold(
    1e-4,
    "1",
    "cut-off, as a share of the Nyquist frequency, below which it is refused",
    "chosen",
)
SETTLED_TRANSIENT = Threshold(
    1e-3,
    "1",
    "share that is left of a filter's transient at which it is over",
    "chosen",
)
MAX_STEP_REMAINDER = Threshold(
    0.05,
    "1",
    "fraction of a step response not yet reached, beyond which a low-pass rounds a reversal",
    "chosen",
)
SAME_FILTER_FREQUENCY = Threshold(
    1.01,
    "1",
    "ratio of two cut-offs up to which they count as one, and of a record's period to that which "
    "a filter was set for up to which its counts of samples stay",
    "chosen",
)
UNIT_FACTOR_TOLERANCE = Threshold(
    0.02,
    "1",
    "relative difference of a record's period from the law's times a unit's factor, up to which "
    "time is in another unit",
    "chosen",
)

# Rows

MIN_ROW_WEIGHT = Threshold(
    0.1,
    "1",
    "weight up to which a row is left out of the fit",
    "chosen",
)
MIN_INFORMATION_LEFT = Threshold(
    2 / 3,
    "1",
    "share of a parameter's information without the samples near reversals, below which they are "
    "kept unless told otherwise",
    "chosen: its deviation is then 1.2 times as large; keeping them is nearer the truth on the "
    "twins of the library from there on, and on held-out motions of the DFKI pendulum",
)
MAX_DEFAULT_CUTOFF = Threshold(
    0.2,
    "1",
    "cut-off where none is given, of the sampling frequency, where 60 Hz would be more",
    "chosen: 60 Hz from 300 Hz on, and two in five of the Nyquist frequency below",
)
