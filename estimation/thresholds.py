"""Thresholds that have a source, or that several modules use.

In: nothing. Out: rows of `Threshold`, by subject; the documentation prints them. Knows nothing of
the modules that use them. A number that is only chosen or measured, for one module, is a constant
of that module, with the reason.
"""

from axisid.support.threshold import Threshold

# Formatted by hand, as a table: the formatter would use six lines for a row.
# fmt: off

# Records
MAX_MEAN_STEP_DEVIATION = Threshold(0.02, "1",
    "relative difference of the median time step, and of any mean over 100 time steps, from "
    "the mean time step, beyond which the sampling period is not constant",
    "chosen")
MAX_EVEN_STEP = Threshold(1.5, "periods",
    "time step beyond which samples are missing, if the time has to be even",
    "chosen")
MAX_UNEVEN_STEP = Threshold(3.0, "periods",
    "time step, in median time steps, beyond which samples are missing, if the time may be "
    "uneven",
    "chosen: shorter steps are interpolated")
MIN_RECORD_SAMPLES = Threshold(3, "rows",
    "smallest number of rows of a record, and of each of its segments",
    "chosen")
LIMIT_TOLERANCE = Threshold(1e-6, "1",
    "relative distance from the drive's limit up to which a control is at the limit",
    "chosen")
MAX_SMOOTH_STEP = Threshold(2.0, "quanta",
    "largest effect of rounding on a smooth signal: step next to a flat extreme, motion at "
    "standstill, deviation from a ramp",
    "derived: a smooth peak with three samples in its top level has smaller steps")
LARGEST_VALUE = Threshold(1e100, "SI",
    "absolute value of a sample beyond which a column is refused",
    "derived: the squares of a million such samples, and their products, are finite in "
    "floating point")

# Filter and motion
REST_SPEED = Threshold(1e-3, "1",
    "share of the largest speed below which an axis is at standstill",
    "chosen")
MIN_MOVING_SPEED = Threshold(0.05, "1",
    "share of the largest speed above which an axis moves",
    "chosen")
MIN_ROW_WEIGHT = Threshold(0.1, "1",
    "weight up to which a row is left out of the estimate",
    "chosen")
MIN_INFORMATION_LEFT = Threshold(2 / 3, "1",
    "share of a parameter's information that remains without samples near reversals; if it is "
    "smaller, these samples are kept",
    "chosen: the standard error without these samples is then 1.2 times as large; below this "
    "share, the estimates with these samples are closer to the true values on the twins of the "
    "library, and on held-out motions of the DFKI pendulum")

# Simulated loop
MAX_STIFFNESS_RATIO = Threshold(16, "1",
    "number of integration steps that the rates of a loop need, relative to the largest "
    "possible number, beyond which the loop is too stiff",
    "derived: rate times step is then about 1")
MAX_WAVE_RATIO = Threshold(2, "1",
    "number of integration steps that the speed of passing a periodic force over the position "
    "needs, relative to the largest possible number, beyond which the loop is too stiff",
    "derived: the error of Simpson's rule is then 2e-5 of the periodic force")
MIN_PHASE_AGREEMENT = Threshold(0.4, "1",
    "mean of the unit vectors by the phase at which a control changes, from which the phase of "
    "the control law is known",
    "derived: a log with three samples in two evaluations of the law gives 0.5, chance almost 0")

# Regression
SIGNIFICANCE_LEVEL = Threshold(0.05, "1",
    "significance level of tests of residuals, of parameters and of nested models",
    "convention")
MAX_AUTOREGRESSION = Threshold(0.97, "1",
    "largest autoregression of scores by which the HAC covariance prewhitens them",
    "[AndrewsMonahan1992]: closer to 1, recolouring would have no bound")
FEW_SCORES = Threshold(25.0, "1",
    "degrees of freedom of HAC below which the standard errors are at least those for "
    "autoregressive residuals",
    "measured: records of 18 s have more, and their intervals cover the true value in 91 to 98 "
    "% of cases; records of 2 s have 5 to 20, and cover it in 53 to 93 %")
MIN_DEGREES_OF_FREEDOM = Threshold(4.0, "1",
    "least degrees of freedom of a standard error for autoregressive residuals",
    "derived: the kurtosis of Student's distribution is unbounded at four or fewer; the "
    "bounded autoregression coefficient leaves it a bound")
MIN_SEGMENT_ROWS = Threshold(8, "rows",
    "smallest number of rows of a segment with a spectrum",
    "derived: a window and three frequencies need as many")
MAX_CHANCE_DEVIATION = Threshold(1.96, "standard deviations",
    "size up to which a correlation of independent series is in 95 % of cases; plots draw this "
    "band",
    "derived: the two-sided 5 % quantile of the normal distribution")
MIN_STEP_DIFFERENCES = Threshold(10, "differences",
    "number of small differences of positions that have to be integer multiples of an encoder "
    "step, from which the step is known",
    "derived: for noise, the probability is 0.3 to the power of this number")

# Estimates
MAX_SIMULATION_ERROR = Threshold(50.0, "%",
    "simulation error (rms), relative to the force (rms), from which the simulated loop does "
    "not follow the record",
    "chosen: the loop then explains three quarters of the force's power")
NO_RELATION = Threshold(100.0, "%",
    "simulation or equation error (rms), relative to the force (rms), from which the model "
    "explains nothing of the record",
    "derived: nothing of the force's power is explained")
CONVERGED = Threshold(1e-2, "standard errors",
    "step of the iteration of the instruments up to which it has converged",
    "chosen")
INTERVAL_LEVEL = Threshold(0.95, "1",
    "probability of the printed intervals",
    "convention")
MIN_ROWS_PER_PARAMETER = Threshold(10, "rows",
    "smallest number of independent rows for each parameter, and of rows in which a parameter "
    "acts, for a reliable standard error",
    "chosen")
MIN_DISTANCE_FROM_NOISE = Threshold(3.0, "standard errors",
    "distance from which a parameter, a factor, a constant or a delay is significant",
    "convention")
LIGHT_ROW = Threshold(0.5, "1",
    "weight under a robust loss below which a row is counted and marked",
    "convention")
MEDIAN_OF_NORMAL = Threshold(0.6744897501960817, "standard deviations",
    "median absolute value of normal noise, by which a median is converted to a standard "
    "deviation",
    "derived: 0.75 quantile of the normal distribution")
HUBER_TUNING = Threshold(1.345, "standard deviations",
    "residual above which Huber's loss is linear instead of quadratic",
    "95 % of the efficiency of least squares for normal noise [Huber1981]")
BISQUARE_TUNING = Threshold(4.685, "standard deviations",
    "residual above which the weight of the bisquare is 0",
    "95 % of the efficiency of least squares for normal noise [HollandWelsch1977]")

# Residual
MIN_MODEL_SHARE = Threshold(0.5, "1",
    "share of the residual's power that repeats with the motion, from which it is reported; "
    "share that a limit of the drive explains, from which the limit is named",
    "chosen: more than half of the residual is then not noise")

# Diagnostics: the control law and the loop
MAX_LAW_RESIDUAL = Threshold(5.0, "%",
    "largest residual (rms) of the declared law, relative to the recorded control (rms)",
    "chosen: with the correct law, it is 0.24 % on the public EMPS record")
MAX_SCALE_ERROR = Threshold(0.01, "1",
    "difference of a factor from 1 above which a column is scaled wrongly, if everything else "
    "agrees",
    "chosen")
MAX_LAW_MOVE = Threshold(2.0, "standard errors",
    "largest change of a parameter by a control law, or a scale of the control, that differs "
    "from the declared one",
    "measured: at most 1.2 on 120 correct twins with a fit of the position")
MAX_ROUNDED_SHARE = Threshold(0.1, "1",
    "share of a gain's effect on the control that the rounding of the log may change, above "
    "which that gain is not estimated",
    "derived: its estimate would be too small by the square of this share, 1 %")
COMPARISON_CUTOFF = Threshold(0.02, "1",
    "cut-off frequency for the comparison of a velocity, force or control, relative to the "
    "sampling rate",
    "chosen")
MAX_LIMIT_EXCESS = Threshold(0.02, "1",
    "distance of a control from the drive's limit, relative to the limit, up to which it is at "
    "the limit",
    "chosen: more than the noise of a converter")
MIN_SAMPLES_PER_FACTOR = Threshold(10, "samples",
    "smallest number of independent samples for each term of a law, to check the law",
    "chosen")
MAX_MISALIGNMENT = Threshold(0.35, "samples",
    "difference between the best delay and the delay in use, or delay of a measured motion, "
    "above which columns are misaligned",
    "chosen: rounding by the filter may look like a delay of up to 0.15 samples")
MAX_DELAY_DEVIATION = Threshold(0.25, "samples",
    "standard error of a delay above which the delay is not reported",
    "chosen")
NO_DELAY = Threshold(0.2, "1",
    "share of a declared delay and lag below which the record has no delay",
    "chosen")

# Diagnostics: estimates
MIN_FIRST_STAGE_F = Threshold(10.0, "1",
    "conditional first-stage F from which instruments are not weak",
    "[StaigerStock1997]; conditional as in [SandersonWindmeijer2016]")
MAX_VARIANCE_INFLATION = Threshold(10.0, "1",
    "variance inflation factor above which a column is nearly a combination of others",
    "convention")
MAX_RELATIVE_DEVIATION = Threshold(30.0, "%",
    "standard error of a parameter, relative to its value, up to which the parameter is "
    "identified",
    "chosen")
MAX_MOVED_PERCENT = Threshold(30.0, "%",
    "largest change of a parameter, relative to its value, by a missing term or in the course "
    "of the record, with which the result can be used",
    "as the standard error up to which a parameter is identified: beyond it, the value is not "
    "a property of the axis")
NEGLIGIBLE_FORCE = Threshold(0.01, "1",
    "share of the force (rms) below which a part of it is negligible",
    "chosen")
NEGLIGIBLE_PEAK_FORCE = Threshold(0.05, "1",
    "share of the largest force that a negligible part may have anywhere in the record",
    "chosen")

# Diagnostics: several records
MIN_COMMON_SAMPLES = Threshold(0.99, "1",
    "share of common samples, between the first and the last of them, from which two records "
    "are the same",
    "chosen: two runs of the same motion differ in more samples even with a coarse encoder")
MAX_REPEATED_SAMPLES = Threshold(1.02, "1",
    "largest mean number of occurrences of a sample in the records",
    "derived: standard errors are then 1 % too small")

# Levels, which are arguments (level=, least_share=)
CHECK_LEVEL = Threshold(0.01, "1",
    "probability that a check fails for a correct model, over all hypotheses of the check: "
    "missing terms, a record that contradicts the others, estimates that differ, fixed values",
    "convention; by Holm's rule over missing terms, by Bonferroni's over the speeds, periods and "
    "times at which a term is tested, and over records")
LEAST_SHARE = Threshold(0.01, "1",
    "share of the force (rms), or of a parameter's value, from which a finding matters; a missing "
    "term also matters if it changes a parameter by more than half the width of its interval",
    "chosen: as for a parameter's part of the force")

# Fits of an output
MIN_SHOWN = Threshold(1e-6, "1",
    "change of the outputs by a parameter, or by a combination of parameters, relative to the "
    "largest change by one parameter, from which the outputs show it",
    "measured: derivatives by differences agree to 1e-8")
ADVISED_WINDOWS = Threshold(20.0, "1",
    "number of windows of an open loop from which standard errors and the search for missing "
    "terms are reliable",
    "chosen: a Stribeck rise of half the Coulomb friction is not found in 16 windows, and is "
    "found in 28")
MAX_GROWTH = Threshold(10.0, "1",
    "displacement by an initial velocity in an open loop, relative to that of a free axis, "
    "above which windows are too long",
    "measured: over strong magnets it is 3 in windows of 0.5 s, and 96 % of the intervals "
    "cover the true value; 19 in 1 s, 68 %; 553 in 2 s, 64 %; with Stribeck friction it is 3 "
    "in 1/16 s and 15 in 0.125 s, 95 %; 494 in 0.25 s, where the intervals are wrong; it is at "
    "most 2.3 in 1 s on 40 machines without these")

# Studies of one or many results
MIN_SWEPT_CUTOFFS = Threshold(3, "cut-offs",
    "smallest number of cut-off frequencies with an estimate by least squares, to recommend "
    "one without instruments",
    "derived: one between two others shows whether the estimate changes")
MIN_BIAS = Threshold(3.0, "1",
    "mean error over twins, in its standard errors, from which it is a bias; for few twins, "
    "Student's quantile of the same probability",
    "chosen: chance exceeds it for 0.3 % of the parameters")
FLEET_LEVEL = Threshold(0.05, "1",
    "probability that logs of a fleet are reported as outliers although all axes are equal",
    "convention")
TREND_LEVEL = Threshold(0.05, "1",
    "probability that a series of results is reported as changed although nothing changed",
    "convention")
