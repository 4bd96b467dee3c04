"""From when on a model lacks something."""

from axisid.codegen.thresholds.threshold import Threshold

LACKING_LEVEL = Threshold(
    0.01,
    "1",
    "chance that anything is told as missing of a right model, over all that is looked for",
    "chosen: Hotelling's test against twins, by Holm's rule and Bonferroni's over places",
)
MIN_LACKING_SHARE = Threshold(
    0.01,
    "1",
    "part of the force, root mean square, beside what the model's own parameters make of it, from "
    "which something missing matters; or it moves a parameter by more than its interval",
    "chosen: as for a parameter's part of the force",
)
MIN_STEPS_EXCESS = Threshold(
    1.2,
    "1",
    "tails of residuals, by the heaviest of loops with the encoder's steps or the record's noise, "
    "below which they are theirs",
    "measured: named in 2 % of right records with 100 steps to a revolution, in 12 % without; 12 "
    "of 390 right records of random axes had a term named without, none of these 12 has",
)
