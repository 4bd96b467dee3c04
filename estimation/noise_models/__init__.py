"""Noise models of records, and simulated replicas of records with that noise.

In: a problem and an estimate. Out: the noise model of each record, a `Chain`; simulated replicas;
their solutions by an estimator. Knows nothing of methods and of verdicts.
"""

from .noise_estimation import measured_noise as measured_noise
from .noise_findings import (
    NoiseSource as NoiseSource,
    NoiseSources as NoiseSources,
    noise_sources as noise_sources,
)
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
