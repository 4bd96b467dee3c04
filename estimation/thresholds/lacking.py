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
