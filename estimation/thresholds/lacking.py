"""From when on a term counts as missing, and a parameter as another in time."""

from axisid.codegen.thresholds.threshold import Threshold

MIN_REST_OF_LOOP = Threshold(
    0.5,
    "1",
    "rest of the simulated loop, by the reach of the low-pass, from which it is no mere turn",
    "chosen",
)
MIN_OWN_PART = Threshold(
    0.05,
    "1",
    "part of a column that the model's own do not span, below which it is not told from them",
    "chosen: its factor has then twenty times the deviation",
)
MIN_OWN_PART_OF_PLAIN = Threshold(
    0.2,
    "1",
    "the same part of Coulomb and viscous friction, below which it is taken as declared",
    "chosen: rows in which a loop turns a sample later leave 0.06 of a declared one",
)
FALSE_DISCOVERY_RATE = Threshold(
    1e-3,
    "1",
    "part of the terms and changes in time that are told of, though they are chance",
    "measured: with 0.01 slow noise is taken for one in 2 % of records, by the HAC deviations",
)
MIN_EXPLAINED_SHARE = Threshold(
    0.05,
    "1",
    "part of the residuals' sum of squares that such a term or change takes, below which it is not "
    "told",
    "chosen",
)
MIN_EXPLAINED_BY_LAST = Threshold(
    0.5,
    "1",
    "part of the residuals' sum of squares that a resonance takes, beside which no other term is "
    "told, below which it is not told either",
    "measured: 0.74 to 0.96 of loads behind a spring, at most 0.25 of rigid axes",
)
NEARLY_AS_GOOD = Threshold(
    0.95,
    "1",
    "gain of a wider peak of friction, by the best one's, up to which it is as good",
    "measured: a narrow one stands for a peak that is hidden while the axis sticks",
)
TRIMMED_SHARE = Threshold(
    0.15,
    "1",
    "part of a parameter's information at either end in which no change in time is looked for",
    "[Andrews1993]",
)
MIN_ROWS_TO_LOOK = Threshold(
    20,
    "rows",
    "rows in motion for each parameter and a constant, below which nothing missing is looked for",
    "chosen",
)
MIN_MISSING_FORCE = Threshold(
    0.01,
    "1",
    "share of the force, root mean square, below which a missing term or a change does not matter",
    "chosen: as for a parameter's part of it",
)
MAX_SCORE_CHANCE = Threshold(
    0.01,
    "1",
    "p-value of the score test beyond which a term or a change is not told, however far it is from "
    "zero by Wald's, which few rows in slow noise mislead",
    "measured: 0.04 and more on right models, 0.003 and less on wrong ones",
)
MIN_STEPS_EXCESS = Threshold(
    1.2,
    "1",
    "what a term or a change takes of the residuals' sum of squares, by the most that its kind "
    "takes of loops that lack nothing and have the encoder's steps or the position's noise, below "
    "which it is theirs; so too of tails and of correlations with the motion",
    "measured: named in 2 % of right records with 100 steps to a revolution, in 12 % without; 12 "
    "of 390 right records of random axes had a term named without, none of these 12 has",
)
MAX_LOSS_OF_FIT = Threshold(
    4.0,
    "1",
    "mean squares that a time of a change fits worse than the best, up to which it does as well",
    "chosen, the square of two deviations",
)
MAX_SHARE_TO_DOUBT = Threshold(
    0.8,
    "1",
    "part of the residuals' sum of squares that a term or a change takes, beyond which the score "
    "test has no say: its covariance is that of residuals which are the term itself",
    "measured: 0.96 and more of a mass 10 % off or a spring that is missing, on quiet records",
)
MAX_UNIT_DISTANCE = Threshold(
    0.02,
    "1",
    "distance of a recorded signal's factor from that of another unit, up to which it is that",
    "chosen",
)
MAX_SIGNAL_DELAY = Threshold(
    0.5,
    "s",
    "delay of a recorded signal beside its force, up to which one is looked for",
    "chosen",
)
