"""What makes a table a record: an even clock, whole columns, signals that are what they claim."""

from axisid.codegen.thresholds.threshold import Threshold

# Clocks

SAME_PERIOD = Threshold(
    5e-4,
    "1",
    "relative difference up to which two sampling periods are the same",
    "chosen: ten times what crystals differ by",
)
MAX_STATED_PERIOD_DEVIATION = Threshold(
    0.005,
    "1",
    "relative difference of a sampling period that was given from the time column's, up to which "
    "it is taken",
    "chosen",
)
MAX_MEAN_STEP_DEVIATION = Threshold(
    0.02,
    "1",
    "relative difference of the mean time step from the median one, and of any window's from that "
    "of all, beyond which a log is refused as uneven",
    "chosen",
)
MAX_PERIOD_DRIFT = Threshold(
    0.005,
    "1",
    "range of the mean time steps of windows, in periods, up to which nothing is said of a drift",
    "chosen: jitter of a quarter of a period moves the mean of a window by as much",
)
MAX_STEP_SPREAD = Threshold(
    0.02,
    "1",
    "range of the time steps, in periods, up to which nothing is said of jitter",
    "chosen",
)
MAX_EVEN_STEP = Threshold(
    1.5,
    "periods",
    "time step beyond which samples are missing, where time is to be even",
    "chosen",
)
MAX_UNEVEN_STEP = Threshold(
    3.0,
    "periods",
    "time step, in median ones, beyond which samples are missing, where time may be uneven",
    "chosen: shorter steps are bridged",
)
MAX_ODD_STEP_SHARE = Threshold(
    0.01,
    "1",
    "share of odd time steps up to which they are faults of single samples; more are jitter",
    "chosen",
)
RESTARTED_CLOCK_STEP = Threshold(
    4.0,
    "periods",
    "time step that stands in place of one of a clock that was set back, so that the log is cut",
    "chosen: more than any gap needs",
)
MIN_PHASE_SUM = Threshold(
    3.5,
    "1",
    "sum of the unit phases of time stamps at a rate, in those of as many random ones, from which "
    "the rate is that of the clock",
    "measured: the largest of a thousand such sums of random phases",
)
LOST_PERIOD_UNCERTAINTY = Threshold(
    0.1,
    "1",
    "relative uncertainty of a mean time step where nothing tells how many samples were lost",
    "chosen",
)
MIN_RESAMPLING_RATE = Threshold(
    0.9,
    "1",
    "rate of resampling, as a share of the position's, below which it is refused, as its noise "
    "would fold",
    "chosen",
)
MIN_RECORD_SAMPLES = Threshold(
    3,
    "rows",
    "rows of a record, and of each of its segments, below which there is none",
    "chosen",
)

# Columns

MIN_NAME_SIMILARITY = Threshold(
    0.8,
    "1",
    "similarity of a column's name to a wanted one, by difflib, from which it is proposed",
    "chosen",
)
MAX_LIMIT_EXCESS_AT_TOP = Threshold(
    0.02,
    "1",
    "distance of a flat top from the drive's limit, as a share of it, up to which it is that",
    "chosen: more than a converter's noise",
)
LIMIT_TOLERANCE = Threshold(
    1e-6,
    "1",
    "relative distance of a control from the drive's limit up to which it is at the limit",
    "chosen",
)

# Samples that were cut off

MIN_FLAT_SAMPLES = Threshold(
    3,
    "samples",
    "equal samples at an extreme from which a signal may have been cut off there",
    "chosen",
)
MIN_ABRUPT_STEP = Threshold(
    0.2,
    "1",
    "step into or out of a flat extreme of the position, as a share of its largest step, from "
    "which it was cut off",
    "chosen",
)
MAX_SMOOTH_STEP = Threshold(
    2.0,
    "quanta",
    "step into or out of a flat extreme, and way during a rest or off a straight ramp, up to which "
    "it is that of a smooth signal's rounding",
    "derived: a smooth peak with three samples in its top level has steps of less",
)
MIN_RAMP_SAMPLES = Threshold(
    4,
    "samples",
    "samples inside a ramp from which it shows that it is straight",
    "chosen",
)
MIN_REST_SAMPLES = Threshold(
    20,
    "samples",
    "samples without motion from which a flat extreme is a rest",
    "chosen",
)
HELD_VALUE_SHARE = Threshold(
    0.1,
    "1",
    "share of a control's values that may be kept for less long than it is held",
    "chosen",
)
MAX_QUANTUM_MULTIPLE = Threshold(
    5.0,
    "quanta",
    "difference of two values up to which it tells whether values are multiples of a quantum",
    "chosen",
)
MAX_QUANTUM_REMAINDER = Threshold(
    0.15,
    "quanta",
    "distance from a whole multiple of a quantum up to which a difference is one",
    "chosen: as decimals leave them",
)
MIN_MULTIPLE_SHARE = Threshold(
    0.9,
    "1",
    "share of the small differences that are whole multiples, beyond which there is a quantum",
    "chosen",
)

# Jumps and turns

MIN_JUMP = Threshold(
    0.5,
    "1",
    "step of the position, as a share of its range, beyond which it may be a jump",
    "chosen",
)
MAX_STEP_BESIDE_JUMP = Threshold(
    0.1,
    "1",
    "steps beside a jump, and the median step, as a share of it, below which it is one",
    "chosen",
)
MAX_TURN_DEVIATION = Threshold(
    0.05,
    "1",
    "relative difference of a jump from a whole turn up to which it is one",
    "chosen: the axis moves on during a jump",
)
MAX_WRAPPED_SPAN = Threshold(
    1.001,
    "1",
    "span of a position, in moduli, up to which it is wrapped by the modulus",
    "chosen: for noise",
)
MAX_SEAM_BEND = Threshold(
    5.0,
    "1",
    "second difference at the seams, times the largest elsewhere, beyond which a modulus is wrong",
    "chosen: more than the seam of a right modulus leaves",
)
MIN_SEAM_BEND = Threshold(
    1e-4,
    "1",
    "second difference at the seams, in moduli, up to which it is rounding",
    "chosen",
)

# Spikes

MIN_SPIKE = Threshold(
    10.0,
    "1",
    "deviation of a sample from the median about it, times the second difference that is seldom "
    "exceeded, beyond which it is a spike",
    "chosen",
)
SELDOM_EXCEEDED = Threshold(
    0.995,
    "1",
    "quantile of the second differences that counts as seldom exceeded",
    "chosen",
)
MIN_SPIKE_WINDOWS = Threshold(
    10,
    "1",
    "samples of a signal, by those that a spike's median is of, below which no spike is looked for",
    "chosen: fewer do not tell how the signal bends elsewhere",
)
MIN_SPIKE_TIP = Threshold(
    0.25,
    "1",
    "second difference at the tip of a spike, as a share of the least spike, beyond which it may "
    "be one",
    "chosen",
)
MIN_SPIKE_SHARE = Threshold(
    1e-3,
    "1",
    "spike, as a share of the signal's range, up to which nothing is said",
    "chosen: where hardly anything moves nothing else is a measure",
)
MAX_STEP_BESIDE_SPIKE = Threshold(
    0.2,
    "1",
    "steps beside a spike, as a share of it, up to which the signal is quiet there",
    "chosen",
)
MAX_STEP_ACROSS_SPIKE = Threshold(
    0.5,
    "1",
    "difference of the two sides of a spike, as a share of it, up to which it is no step",
    "chosen",
)
MIN_COUNTS = Threshold(
    10,
    "values",
    "different whole numbers that a position without a unit needs to be taken for counts",
    "chosen: metres or radians are whole by chance in no log; fewer are a test of a few rows",
)
MIN_SELDOM_CHANGES = Threshold(
    20,
    "values",
    "values of a column from which it is told in how many samples each stands",
    "chosen: fewer come at even distances by chance",
)
MIN_SAME_PHASE = Threshold(
    0.95,
    "1",
    "share of a column's changes that come at one even distance, from which it is written seldomer "
    "than the log",
    "chosen: of a column that is rounded they come at any distance",
)
MAX_PART_OF_A_SAMPLE = Threshold(
    0.01,
    "samples",
    "distance of the time that a column is moved by from a whole number of samples, up to which it "
    "is that number",
    "chosen: a time that is written with two digits",
)
LARGEST_VALUE = Threshold(
    1e100,
    "SI",
    "size of a sample beyond which a column is refused",
    "derived: the squares of a million of such samples, and their products, are still numbers",
)
