"""What a regression can tell, and the level at which its tests speak."""

from axisid.codegen.thresholds.threshold import Threshold

MIN_SINGULAR_VALUE_RATIO = Threshold(
    1e-11,
    "1",
    "smallest singular value of unit columns, by the largest, up to which columns are dependent",
    "measured: filtering leaves rounding of up to 1e-12 in columns that are dependent",
)
MIN_TRADE_WEIGHT = Threshold(
    1e-6,
    "1",
    "weight of a parameter in a change that the fit does not notice, by the largest, from which it "
    "is named",
    "chosen: far above rounding, and below any trade that matters",
)
SIGNIFICANCE_LEVEL = Threshold(
    0.05,
    "1",
    "level at which tests of residuals, of parameters and of nested models reject",
    "convention",
)
MAX_AUTOREGRESSION = Threshold(
    0.97,
    "1",
    "autoregression of scores up to which the HAC covariance whitens them",
    "[AndrewsMonahan1992]: nearer to one it would recolour without end",
)
FEW_SCORES = Threshold(
    25.0,
    "1",
    "degrees of freedom of the HAC covariance below which its deviations are no smaller than those "
    "of autoregressive residuals",
    "measured: records of 18 s have more and hold 91 to 98 %; of 2 s 5 to 20, and hold 53 to 93 %",
)
MAX_RESIDUAL_AUTOREGRESSION = Threshold(
    0.99,
    "1",
    "autoregression of residuals up to which the covariance of few scores takes them to go",
    "chosen: a hundred rows, beyond which a short record cannot tell it from a drift",
)
MIN_FREEDOM = Threshold(
    4.0,
    "1",
    "degrees of freedom that a deviation of autoregressive residuals has at least",
    "derived: the kurtosis of Student's distribution has no bound at four or fewer, and a "
    "coefficient that is bounded, as this is, leaves it one",
)
MIN_SEGMENT_ROWS = Threshold(
    8,
    "rows",
    "rows of a segment below which there is no spectrum",
    "derived: what a window and three frequencies need",
)
MIN_SEGMENTED_SHARE = Threshold(
    0.5,
    "1",
    "share of the rows that stand in stretches of a segment or more, where there is a spectrum",
    "chosen",
)
MAX_CHANCE_DEVIATION = Threshold(
    1.96,
    "deviations",
    "distance from chance within which a correlation of independent series stays in 95 % of "
    "cases; drawn",
    "derived: the two-sided 5 % quantile of the normal distribution",
)
LEAST_MEASURED_NOISE = Threshold(
    0.8,
    "1",
    "part of the control law's answer to the recorded position's noise that the recorded control "
    "has, from which the law measured what was recorded",
    "chosen: 1 where it did, and 0 where a log is coarser than what the law measures",
)
MAX_DITHERED_SHARE = Threshold(
    0.5,
    "1",
    "share of its samples at which a rounded velocity changes, from which its noise averages the "
    "steps",
    "chosen: at a constant speed noise of half a step changes as many",
)
MIN_STEP_DIFFERENCES = Threshold(
    10,
    "differences",
    "small differences of recorded positions that have to be whole multiples of an encoder's step",
    "derived: of noise, all are with a chance of 0.3 to the power of their number",
)
MAX_CONTROL_STEPS = Threshold(
    1024,
    "1",
    "steps of a recorded control, or force, in its whole range from which on what they move is no "
    "matter",
    "chosen: half a step is then 0.05 % of the range; measured on a quiet axis, 64 steps moved a "
    "viscous friction by 2.3 %, four deviations, 256 by a quarter of one",
)
