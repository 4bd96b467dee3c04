"""Figures as data.

In: a result. Out: `Plot`. Knows nothing of Matplotlib and of pages.
"""

from .estimate import (
    autocorrelation_plot as autocorrelation_plot,
    convergence_plot as convergence_plot,
    force_plot as force_plot,
    row_times as row_times,
    spectrum_plot as spectrum_plot,
)
from .friction import friction_plot as friction_plot
from .output_fit import output_plot as output_plot
from .plot import (
    SHADED as SHADED,
    TITLES as TITLES,
    Panel as Panel,
    Plot as Plot,
    Series as Series,
    Tone as Tone,
    drawable as drawable,
    labelled as labelled,
    paired as paired,
)
from .repeats import mean_residual_plot as mean_residual_plot, repeats_plot as repeats_plot
from .result import (
    record_plot as record_plot,
    result_plots as result_plots,
    sweep_plot as sweep_plot,
    tracking_plot as tracking_plot,
)
from .several import plots_by_record as plots_by_record
