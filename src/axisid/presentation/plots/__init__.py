"""Figures as data.

In: a result. Out: a `Plot`. Knows nothing of Matplotlib and pages.
"""

from .fit_and_residuals import (
    autocorrelation_plot as autocorrelation_plot,
    convergence_plot as convergence_plot,
    force_plot as force_plot,
    friction_plot as friction_plot,
    output_plot as output_plot,
    repeats_plot as repeats_plot,
    row_times as row_times,
    spectrum_plot as spectrum_plot,
)
from .monte_carlo import (
    PLOTS as PLOTS,
    method_title as method_title,
    monte_carlo_plot as monte_carlo_plot,
    monte_carlo_plots as monte_carlo_plots,
)
from .plot import (
    SHADED as SHADED,
    TITLES as TITLES,
    Panel as Panel,
    Plot as Plot,
    PlotSeries as PlotSeries,
    Tone as Tone,
    labelled as labelled,
    paired as paired,
    with_series as with_series,
)
from .result import (
    numbered as numbered,
    plots_by_record as plots_by_record,
    record_plot as record_plot,
    result_plots as result_plots,
    sweep_plot as sweep_plot,
    tracking_plot as tracking_plot,
)
