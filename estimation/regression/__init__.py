"""Regression: rows of the model from signals, their solution, and its covariance.

In: `Signals`. Out: `Equations`, `Solution`, `Covariance`.
Knows nothing of verdicts.
"""

from .coloured_errors import (
    Autoregression as Autoregression,
    autoregression_of as autoregression_of,
    autoregressive_covariance as autoregressive_covariance,
    clustered_covariance as clustered_covariance,
    sum_covariances as sum_covariances,
    widened as widened,
)
from .covariance import (
    Classical as Classical,
    Covariance as Covariance,
    Hac as Hac,
    PublishedCovariance as PublishedCovariance,
    Robust as Robust,
    correlation as correlation,
    delta_method as delta_method,
    hotelling_p_value as hotelling_p_value,
    wald as wald,
)
from .covariance_note import CovarianceNote as CovarianceNote
from .inverse_and_direct import (
    DirectForm as DirectForm,
    Equations as Equations,
    Form as Form,
    InverseForm as InverseForm,
    damped_step as damped_step,
    search_bounds as search_bounds,
    separable_least_squares as separable_least_squares,
)
from .linear import (
    Columns as Columns,
    CovarianceEstimate as CovarianceEstimate,
    LossWeights as LossWeights,
    QrFactors as QrFactors,
    Solution as Solution,
    checked_columns as checked_columns,
    condition_number as condition_number,
    factor as factor,
    instrumental_variables as instrumental_variables,
    least_squares as least_squares,
)
from .propagation import (
    Drawn as Drawn,
    DrawSummary as DrawSummary,
    covariance_root as covariance_root,
    curvature as curvature,
    draw_parameters as draw_parameters,
    scaled_gradients_and_hessians as scaled_gradients_and_hessians,
    summary_of_draws as summary_of_draws,
)
from .residual_tests import (
    ResidualTests as ResidualTests,
    power_density as power_density,
    residual_tests as residual_tests,
)
from .simulated_instruments import (
    LoopDataError as LoopDataError,
    is_measured_by_law as is_measured_by_law,
    lacking_law as lacking_law,
    lacking_loop as lacking_loop,
    loop_carries_noise as loop_carries_noise,
    loop_reference as loop_reference,
    recorded_loops as recorded_loops,
    simulated_loops as simulated_loops,
    simulated_position as simulated_position,
    simulated_rows as simulated_rows,
)
