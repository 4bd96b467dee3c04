"""The declared control law held against what the drive did.

In: an axis and a record. Out: `LawAgreement`, with what would mend it.
Knows nothing of estimates, and of what the loop makes of the law.
"""

from .control_residuals import (
    CONSTANT as CONSTANT,
    DRIFT as DRIFT,
    comparison_filter as comparison_filter,
)
from .gain_regression import (
    GAINS as GAINS,
    SCALE as SCALE,
    Explanation as Explanation,
    GainRegression as GainRegression,
)
from .law_agreement import (
    EstimatedGains as EstimatedGains,
    LawAgreement as LawAgreement,
    first_failing as first_failing,
    found_law_agreement as found_law_agreement,
    law_agreement as law_agreement,
    law_check as law_check,
)
from .noise_gain import NOISE_GAIN as NOISE_GAIN, noise_gain_check as noise_gain_check
from .record_laws import RecordLaws as RecordLaws
