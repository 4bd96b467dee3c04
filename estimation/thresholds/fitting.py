"""What fits of outputs are judged by."""

from axisid.codegen.thresholds.threshold import Threshold

MIN_SHOWN = Threshold(
    1e-6,
    "1",
    "change of the outputs with a parameter, or a sum of them, by that with the one that they show "
    "best, up to which they show nothing of it",
    "measured: slopes by differences agree to 1e-8",
)
MAX_LAW_SHIFT = Threshold(
    2.0,
    "deviations",
    "move of a parameter by what the record's control law is other than the declared one, beyond "
    "which it is not believed",
    "measured: at most 1.2 on 120 right twins whose position is followed, 120 with kp 1 % wrong",
)
MAX_LAW_SENSITIVITY = Threshold(
    5.0,
    "%",
    "move of a parameter by 1 % of a term of the control law, beyond which it is said that the law "
    "must be exact",
    "measured: 0.4 where the control is followed, 43 where the position is",
)
MAX_APART = Threshold(
    0.5,
    "1",
    "share of the searches that end higher than the best, beyond which that is said",
    "chosen: the lowest end is then found by few",
)
MIN_FAR = Threshold(
    6.0,
    "deviations",
    "distance of a place that the search passed from its end, beyond which it is asked whether the "
    "errors tell the two apart",
    "chosen: nearer ones may be as good by chance",
)
MAX_FAR = Threshold(
    2.0,
    "deviations",
    "distance of such a place by what its errors are more than those of the end, below which the "
    "deviations are too small",
    "chosen: noise alone tells two places that far apart in 1 of 20",
)
AT_BOUND = Threshold(
    0.05,
    "deviations",
    "distance from a bound up to which a parameter that the errors drive there is at it",
    "chosen: it is held there then, and moves by no more",
)
MIN_PART = Threshold(
    0.1,
    "1",
    "change of the outputs by a parameter along a direction that they do not show, by the largest, "
    "from which it is named with it",
    "chosen",
)
MIN_PAIRS = Threshold(
    0.25,
    "1",
    "pairs of errors so many samples apart between masks, over the errors, from which their lag is "
    "told",
    "measured: with half of the samples masked, at random or in blocks, 0.9 to 1.4 times the "
    "scatter is claimed",
)
SAME_END = Threshold(
    1e-3,
    "1",
    "excess of a search's cost over the least, up to which it ended there too",
    "chosen",
)
MAX_BEYOND_NOISE = Threshold(
    15.0,
    "%",
    "part of a recorded output that a simulated one leaves beyond noise, from which it does not "
    "follow it",
    "chosen: it is 4.5 on the EMPS record, whose model lacks 6 % of the control",
)
MAX_LEFT = Threshold(
    120.0,
    "%",
    "part of a recorded output that a simulated one leaves, noise counted, from which it does not "
    "follow it",
    "chosen: a loop that does nothing leaves 100, and noise beside a small motion hardly more",
)
MAX_TIME_STEP = Threshold(
    0.01,
    "periods",
    "distance of a drive's time that a search ends at from that of its loop, up to which the loop "
    "need not be generated anew",
    "chosen: the output is a straight line of it there",
)
ADVISED_WINDOWS = Threshold(
    20.0,
    "1",
    "windows of an open loop below which neither deviations nor a missing term are told for sure",
    "chosen: a Stribeck rise of half the Coulomb friction goes untold in 16, and is told in 28",
)
SCORES_ALIKE = Threshold(
    0.4,
    "s",
    "distance up to which errors of an axis whose friction remembers are held against each other",
    "measured: deviations of a LuGre axis by half of it are 0.5 to 0.9 of their scatter, by all of "
    "it 0.6 to 1.0; twins have the rest",
)
MIN_MOVED_BY_NOISE = Threshold(
    1.0,
    "deviations",
    "move of a parameter by noise in the loop, which is taken off, from which it is said",
    "chosen",
)
MIN_MOVED_BY_START = Threshold(
    1.0,
    "deviations",
    "move of a parameter by the start of a loop, were that free with it, from which it is said and "
    "counts in the deviations",
    "measured: of twins cut 0.1 s long from a move 80 % of intervals hold without, 100 % with",
)
FEWEST_TWINS = Threshold(
    16.0,
    "1",
    "twins with noise, or pairs of opposite ones, that could be simulated, from which they tell "
    "deviations and what noise moves",
    "chosen: a deviation is known to 18 % then",
)
MAX_WEIGHT = Threshold(
    1e20,
    "1/unit of the output",
    "weight of an output, and its inverse, up to which it is taken",
    "chosen: with more, what another output tells is lost to rounding",
)
MIN_PRIOR_DEVIATION = Threshold(
    1e-12,
    "1",
    "deviation of what was known of a parameter, by its value, from which it is weighed",
    "chosen: what is surer is exact, and can be held",
)
MAX_GROWTH = Threshold(
    10.0,
    "1",
    "way to which a first velocity carries an axis in an open loop, by that of a free one, beyond "
    "which its windows are too long",
    "measured: over strong magnets 3 in windows of 0.5 s, of whose fits 96 % of intervals hold, 19 "
    "in 1 s, 68 %, 553 in 2 s, 64 %; with Stribeck friction 3 in 1/16 s and 15 in 0.125 s, 95 %, "
    "494 in 0.25 s, whose fits do not hold; 2.3 at most in 1 s on 40 machines without",
)
HORIZON = Threshold(
    1.0,
    "s",
    "length of the windows of an open loop where none is given",
    "chosen",
)
