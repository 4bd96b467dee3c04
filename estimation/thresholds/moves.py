"""Thresholds of moves, of what repeats and of the model's error."""

from axisid.codegen.thresholds.threshold import Threshold

# Moves

MIN_MOVE_SPEED = Threshold(
    0.02,
    "1",
    "share of the largest speed that a move has to reach",
    "chosen",
)
MIN_MOVE_PROMINENCE = Threshold(
    0.5,
    "1",
    "share of its largest speed that a move has to fall by before the next begins",
    "chosen",
)
MAX_LEVEL_SPREAD = Threshold(
    0.1,
    "1",
    "relative difference up to which largest speeds are of one level",
    "chosen",
)

# Repeats

MAX_REPEAT_DIFFERENCE = Threshold(
    1e-4,
    "1",
    "difference of two moves of the reference, as a share of its travel, up to which they are the "
    "same",
    "chosen: logged digits differ by less, other moves by more",
)
MIN_REPEATED_ROWS = Threshold(
    50,
    "rows",
    "rows at phases that repeat, below which residuals are not split",
    "chosen",
)
MAX_REPEAT_CHANCE = Threshold(
    1e-3,
    "1",
    "chance that noise alone repeats as much, up to which something of the residuals repeats",
    "chosen",
)
MIN_MODEL_SHARE = Threshold(
    0.5,
    "1",
    "share of the residuals' power that repeats, from which it is noted",
    "chosen: more than half of what is left is no noise",
)
MIN_SMOOTHNESS = Threshold(
    0.25,
    "1",
    "correlation of what repeats with that of the next row, from which it is the model's",
    "measured: 0.5 to 0.99 for missing terms, -0.5 for the steps of an encoder",
)
MIN_HAC_EXCESS = Threshold(
    1.5,
    "1",
    "HAC deviations in those of the noise alone, from which they are said to be too wide for it",
    "chosen",
)

# Model's error

MIN_GROUPS = Threshold(
    3,
    "groups",
    "groups of rows from which an estimate is made again without each",
    "chosen: two do not tell how far they scatter",
)
MAX_DELETED_INFLATION = Threshold(
    20.0,
    "1",
    "variance of a parameter without a group, in that with all, up to which the estimate without "
    "it is believed",
    "chosen",
)
MIN_BAND_EXCESS = Threshold(
    1.5,
    "1",
    "band of the model's error in the half of the 95 % interval, from which it is shown",
    "chosen",
)
MAX_BAND_CHANCE = Threshold(
    3e-3,
    "1",
    "chance that noise alone makes the groups scatter as far, up to which the band is shown where "
    "no repeats tell what is noise",
    "chosen: each parameter of a result is looked at under three ways to form groups",
)
MIN_SPEED_OF_A_MOVE = Threshold(
    1e-3,
    "1",
    "share of the largest speed below which the axis is between two moves",
    "chosen",
)
