"""A record's loop once more, with noise as the record has it.

In: a problem, an estimate of it. Out: the noise model of the record, a `Chain`, its twins, and what
an estimator makes of them. Knows nothing of methods and of verdicts.
"""

from .noise_estimation import measured_noise as measured_noise
from .noise_model import (
    Autoregressions as Autoregressions,
    Chain as Chain,
    Draws as Draws,
    MeasuredChain as MeasuredChain,
)
from .twins import (
    DEFAULT_COUNT as DEFAULT_COUNT,
    Twins as Twins,
    check_count as check_count,
    noise_free_record as noise_free_record,
    twins_of as twins_of,
)
