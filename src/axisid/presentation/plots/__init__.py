"""Figures as data.

In: a result. Out: `Plot`. Knows nothing of Matplotlib and of pages.
"""

from .estimate import autocorrelation_plot as autocorrelation_plot
from .estimate import convergence_plot as convergence_plot
from .estimate import force_plot as force_plot
from .estimate import row_times as row_times
from .estimate import spectrum_plot as spectrum_plot
from .friction import friction_plot as friction_plot
from .output_fit import output_plot as output_plot
from .plot import SHADED as SHADED
from .plot import TITLES as TITLES
from .plot import Panel as Panel
from .plot import Plot as Plot
from .plot import Series as Series
from .plot import Tone as Tone
from .plot import drawable as drawable
from .plot import labelled as labelled
from .plot import paired as paired
from .repeats import mean_residual_plot as mean_residual_plot
from .repeats import repeats_plot as repeats_plot
from .result import record_plot as record_plot
from .result import result_plots as result_plots
from .result import sweep_plot as sweep_plot
from .result import tracking_plot as tracking_plot
from .several import plots_by_record as plots_by_record
