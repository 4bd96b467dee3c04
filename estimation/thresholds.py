"""Numbers by which something is judged and that have a source, or by which several rooms judge.

In: nothing. Out: rows of `Threshold`, by room; the documentation prints them. Knows nothing of who
judges by them. A number that is only chosen or measured, for one room, is a constant beside what
judges by it, with the reason.
"""

from axisid.support.threshold import Threshold

# Packed by hand, as a table: the formatter would make six lines of a row.
# fmt: off

# Records
MAX_MEAN_STEP_DEVIATION = Threshold(0.02, "1",
    "of a mean time step from the median one, and of a window's from all, relative", "chosen")
MAX_EVEN_STEP = Threshold(1.5, "periods",
    "time step beyond which samples are missing, where time is to be even", "chosen")
MAX_UNEVEN_STEP = Threshold(3.0, "periods", "the same in median ones, where time may be uneven",
    "chosen: shorter steps are bridged")
MIN_RECORD_SAMPLES = Threshold(3, "rows", "of a record, and of each of its segments", "chosen")
LIMIT_TOLERANCE = Threshold(1e-6, "1",
    "relative distance of a control from the drive's limit that it is at", "chosen")
MAX_SMOOTH_STEP = Threshold(2.0, "quanta",
    "step beside a flat extreme, way in a rest or off a ramp, that rounding makes of a smooth "
    "signal", "derived: a smooth peak with three samples in its top level has steps of less")
LARGEST_VALUE = Threshold(1e100, "SI", "size of a sample beyond which a column is refused",
    "derived: the squares of a million of such samples, and their products, are still numbers")

# Filter and motion
REST_SPEED = Threshold(1e-3, "1", "share of the largest speed below which an axis rests", "chosen")
MIN_MOVING_SPEED = Threshold(0.05, "1", "share of the largest speed beyond which an axis moves",
    "chosen")
MIN_ROW_WEIGHT = Threshold(0.1, "1", "weight up to which a row is left out of the fit", "chosen")
MIN_INFORMATION_LEFT = Threshold(2 / 3, "1",
    "share of a parameter's information without samples near reversals, below which they are kept",
    "chosen: its deviation is then 1.2 times as large; keeping them is nearer the truth on the "
    "twins of the library from there on, and on held-out motions of the DFKI pendulum")

# Simulated loop
MAX_STIFFNESS_RATIO = Threshold(16, "1",
    "steps that a loop's rates ask for, by the most there are, beyond which it is too stiff",
    "derived: rate times step is then near 1")
MAX_WAVE_RATIO = Threshold(2, "1",
    "the same for the speed at which it passes a wave of the position",
    "derived: Simpson's rule then errs by 2e-5 of the wave")
MIN_PHASE_AGREEMENT = Threshold(0.4, "1",
    "mean of unit vectors by the phase at which a control changes, which tells when a law runs",
    "derived: a log three samples of which fall on two evaluations gives 0.5, chance next to none")

# Regression
SIGNIFICANCE_LEVEL = Threshold(0.05, "1",
    "of tests of residuals, of parameters and of nested models", "convention")
MAX_AUTOREGRESSION = Threshold(0.97, "1",
    "autoregression of scores up to which the HAC covariance whitens them",
    "[AndrewsMonahan1992]: nearer to one it would recolour without end")
FEW_SCORES = Threshold(25.0, "1",
    "degrees of freedom of HAC, below which deviations are at least those of autoregressive "
    "residuals",
    "measured: records of 18 s have more and hold 91 to 98 %; of 2 s 5 to 20, and hold 53 to 93 %")
MIN_DEGREES_OF_FREEDOM = Threshold(4.0, "1",
    "degrees of freedom that a deviation of autoregressive residuals has at least",
    "derived: the kurtosis of Student's distribution has no bound at four or fewer, and a "
    "coefficient that is bounded, as this is, leaves it one")
MIN_SEGMENT_ROWS = Threshold(8, "rows", "of a segment with a spectrum",
    "derived: what a window and three frequencies need")
MAX_CHANCE_DEVIATION = Threshold(1.96, "deviations",
    "distance within which a correlation of independent series stays in 95 % of cases; drawn",
    "derived: the two-sided 5 % quantile of the normal distribution")
MIN_STEP_DIFFERENCES = Threshold(10, "differences",
    "small differences of positions that have to be whole multiples of an encoder's step",
    "derived: of noise, all are with a chance of 0.3 to the power of their number")

# Estimates
MAX_SIMULATION_ERROR = Threshold(50.0, "%",
    "simulation error from which the simulated loop does not follow the record",
    "chosen: the loop then explains three quarters of the force's power")
NO_RELATION = Threshold(100.0, "%",
    "error, of simulation or equation, from which it explains nothing of the record",
    "derived: nothing of the force's power is explained")
CONVERGED = Threshold(1e-2, "deviations",
    "step of the instruments' iteration up to which it has converged", "chosen")
INTERVAL_LEVEL = Threshold(0.95, "1", "probability of the intervals that are printed", "convention")
MIN_ROWS_PER_PARAMETER = Threshold(10, "rows",
    "for each parameter, or that tell of one, to believe its deviation", "chosen")
MIN_DISTANCE_FROM_NOISE = Threshold(3.0, "deviations",
    "from which a parameter, a factor, a constant, a delay stands out", "convention")
LIGHT_ROW = Threshold(0.5, "1",
    "weight under a robust loss below which a row is counted and marked", "convention")
MEDIAN_OF_NORMAL = Threshold(0.6744897501960817, "deviations",
    "median size of normal noise, by which a deviation is told from a median",
    "derived: 0.75 quantile of the normal distribution")
HUBER_TUNING = Threshold(1.345, "deviations",
    "size from which Huber's loss no longer counts a residual by its square",
    "95 % as precise as least squares where noise is normal [Huber1981]")
BISQUARE_TUNING = Threshold(4.685, "deviations",
    "size from which the bisquare does not count a residual at all",
    "95 % as precise as least squares where noise is normal [HollandWelsch1977]")

# Moves
MIN_MODEL_SHARE = Threshold(0.5, "1",
    "share of the residuals' power that repeats, from which it is noted; that a limit of the drive "
    "explains, from which it is named",
    "chosen: more than half of what is left is no noise")

# Diagnostics: the control law and the loop
MAX_LAW_RESIDUAL = Threshold(5.0, "%", "part of the recorded control that a law may leave",
    "chosen: it is 0.24 % on the EMPS record")
MAX_SCALE_ERROR = Threshold(0.01, "1",
    "of a factor from 1, where all else fits: a column is scaled wrongly", "chosen")
MAX_LAW_MOVE = Threshold(2.0, "standard errors",
    "of a parameter, by a law or a scale of the control that is not the declared one",
    "measured: at most 1.2 on 120 right twins whose position is followed")
MAX_ROUNDED_SHARE = Threshold(0.1, "1",
    "part of what a gain changes of a control that the log may round, to tell of that gain",
    "derived: its estimate would be low by the square of it, 1 %")
COMPARISON_CUTOFF = Threshold(0.02, "1",
    "cut-off of a compared velocity, force or control, by the sampling rate", "chosen")
MAX_LIMIT_EXCESS = Threshold(0.02, "1",
    "control beyond the drive's limit, by it, up to which it is at the limit",
    "chosen: more than a converter's noise")
MIN_SAMPLES_PER_FACTOR = Threshold(10, "samples",
    "independent ones, that are compared for each term of a law, to check it", "chosen")
MAX_MISALIGNMENT = Threshold(0.35, "samples",
    "distance of the delay that fits best from the one that is used; delay of a measured motion",
    "chosen: rounding by the filter may look like up to 0.15 samples")
MAX_DELAY_DEVIATION = Threshold(0.25, "samples",
    "deviation of the delay beyond which nothing is said of it", "chosen")
NO_DELAY = Threshold(0.2, "1", "share of a declared delay and lag, below which the record has none",
    "chosen")

# Diagnostics: estimates
MIN_FIRST_STAGE_F = Threshold(10.0, "1",
    "conditional first-stage F from which instruments are not weak",
    "[StaigerStock1997]; conditional as in [SandersonWindmeijer2016]")
MAX_VARIANCE_INFLATION = Threshold(10.0, "1",
    "variance inflation from which a column nearly repeats others", "convention")
MAX_RELATIVE_DEVIATION = Threshold(30.0, "%", "up to which a parameter is known", "chosen")
MAX_MOVED_PERCENT = Threshold(30.0, "%",
    "of its value, by which something that the model lacks may move a parameter, or a parameter "
    "change in the record, before the result is not believed",
    "as the deviation up to which a parameter is known: further off, the value is no property of "
    "the axis")
NEGLIGIBLE_FORCE = Threshold(0.01, "1",
    "share of the force below which a part of it does not matter", "chosen")
NEGLIGIBLE_PEAK_FORCE = Threshold(0.05, "1",
    "the same anywhere along the record, as a share of the largest force", "chosen")

# Diagnostics: several records
MIN_COMMON_SAMPLES = Threshold(0.99, "1",
    "part of the samples between the first and the last that two records have in common",
    "chosen: runs of one motion before a coarse encoder have others between")
MAX_REPEATED_SAMPLES = Threshold(1.02, "1", "how often a sample is among the records, on average",
    "derived: deviations 1 % too small")

# Levels, which are arguments (level=, least_share=)
CHECK_LEVEL = Threshold(0.01, "1",
    "chance that a check tells anything of a right model, over all that it looks for: what is "
    "missing, a record that speaks against the rest, estimates apart, what was fixed",
    "convention; by Holm's rule over what is missing, by Bonferroni's over places and records")
LEAST_SHARE = Threshold(0.01, "1",
    "of the force, root mean square, or of a parameter's value, from which that matters; what is "
    "missing does too where it moves a parameter by more than its interval",
    "chosen: as for a parameter's part of the force")

# Fits of an output
MIN_SHOWN = Threshold(1e-6, "1",
    "change of the outputs with a parameter, or a sum of them, by the most that one makes",
    "measured: slopes by differences agree to 1e-8")
ADVISED_WINDOWS = Threshold(20.0, "1",
    "windows of an open loop from which deviations and missing terms are told for sure",
    "chosen: a Stribeck rise of half the Coulomb friction goes untold in 16, and is told in 28")
MAX_GROWTH = Threshold(10.0, "1",
    "way by a first velocity in an open loop, by that of a free axis; longer windows are too long",
    "measured: over strong magnets 3 in windows of 0.5 s, of whose fits 96 % of intervals hold, "
    "19 in 1 s, 68 %, 553 in 2 s, 64 %; with Stribeck friction 3 in 1/16 s and 15 in 0.125 s, 95 "
    "%, 494 in 0.25 s, whose fits do not hold; 2.3 at most in 1 s on 40 machines without")

# Studies of one or many results
MIN_SWEPT_CUTOFFS = Threshold(3, "cut-offs",
    "with an estimate by least squares, to recommend one without instruments",
    "derived: one between two others stands still or does not")
MIN_BIAS = Threshold(3.0, "1",
    "mean error over twins, in its standard errors, that is a bias; of few, Student's quantile",
    "chosen: chance exceeds it in 0.3 % of parameters")
FLEET_LEVEL = Threshold(0.05, "1", "chance that logs of a fleet stand out though all are alike",
    "convention")
TREND_LEVEL = Threshold(0.05, "1",
    "chance that results of a series are told as changed though none is", "convention")
