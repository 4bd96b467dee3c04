"""A record's loop once more, with noise as the record has it, and what estimates make of it.

In: a problem, an estimate of it. Out: the noise model of the record, a `Chain`, its twins, and by
them the estimate's bias and deviations. Knows nothing of methods and of verdicts.
"""

from .bootstrap_correction import (
    BootstrapCorrection as BootstrapCorrection,
    bootstrap_correction as bootstrap_correction,
)
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
    twins_of as twins_of,
)
