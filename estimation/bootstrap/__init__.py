"""A record's loop once more, with noise as the record has it, and what estimates make of it.

In: a problem, an estimate of it. Out: the chain of noise that the record was measured through,
twins, and by them the estimate's bias and deviations. Knows nothing of methods and of verdicts.
"""

from .noise_estimation import measured_chain as measured_chain
from .noise_model import (
    Autoregressions as Autoregressions,
    Chain as Chain,
    Draws as Draws,
    MeasuredChain as MeasuredChain,
)
from .twins import (
    DEFAULT_COUNT as DEFAULT_COUNT,
    BootstrapCorrection as BootstrapCorrection,
    Twins as Twins,
    bootstrap_correction as bootstrap_correction,
    check_count as check_count,
    twins_of as twins_of,
)
