"""Signals as rows, and rows solved.

In: `Signals`. Out: `Equations`, `Solution`, `Covariance`.
Knows nothing of verdicts.
"""

from .coloured_errors import (
    Autoregression as Autoregression,
    added as added,
    autoregression_of as autoregression_of,
    by_colour as by_colour,
    by_windows as by_windows,
    larger as larger,
)
from .covariance import (
    Classical as Classical,
    Covariance as Covariance,
    Hac as Hac,
    PublishedCovariance as PublishedCovariance,
    Robust as Robust,
    correlation as correlation,
    delta_method as delta_method,
    joint_p as joint_p,
    most_lags as most_lags,
    score_products as score_products,
    wald as wald,
    widened as widened,
)
from .forms import (
    DirectForm as DirectForm,
    Equations as Equations,
    Form as Form,
    InverseForm as InverseForm,
)
from .linear import (
    Applied as Applied,
    Columns as Columns,
    QrFactors as QrFactors,
    RowCounts as RowCounts,
    Solution as Solution,
    as_counted as as_counted,
    checked_columns as checked_columns,
    condition_number as condition_number,
    factor as factor,
    instrumental_variables as instrumental_variables,
    least_squares as least_squares,
)
from .propagation import (
    Bend as Bend,
    Drawn as Drawn,
    DrawSummary as DrawSummary,
    bend as bend,
    draw_parameters as draw_parameters,
    root as root,
    summarised as summarised,
)
from .residual_tests import (
    ResidualTests as ResidualTests,
    power_density as power_density,
    residual_tests as residual_tests,
)
from .simulated_rows import (
    LoopDataError as LoopDataError,
    follows_noise as follows_noise,
    is_measured_by_law as is_measured_by_law,
    lacking_law as lacking_law,
    lacking_loop as lacking_loop,
    loop_reference as loop_reference,
    recorded_loops as recorded_loops,
    sensor_steps as sensor_steps,
    simulated_loops as simulated_loops,
    simulated_position as simulated_position,
    simulated_right as simulated_right,
)
from .variable_projection import (
    damped_step as damped_step,
    search_bounds as search_bounds,
    variable_projection as variable_projection,
)
