"""A record's loop once more, with noise as the record has it.

In: a problem, an estimate of it. Out: the noise model of the record, a `Chain`, its twins, and what
an estimator makes of them. Knows nothing of methods and of verdicts.
"""

from .noise_estimation import measured_noise as measured_noise
from .noise_model import (
    AntitheticDraws as AntitheticDraws,
    Autoregressions as Autoregressions,
    Chain as Chain,
    MeasuredChain as MeasuredChain,
)
from .twins import (
    DEFAULT_TWIN_COUNT as DEFAULT_TWIN_COUNT,
    Twins as Twins,
    check_twin_count as check_twin_count,
    noise_free_record as noise_free_record,
    pair_freedom as pair_freedom,
    twins_of as twins_of,
)
