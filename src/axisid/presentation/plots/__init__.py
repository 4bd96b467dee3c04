"""Figures as data, and as drawn by Matplotlib.

In: a result. Out: `Plot`, figures, their files. Computes no statistics.
"""

from .estimate import autocorrelation_plot as autocorrelation_plot
from .estimate import convergence_plot as convergence_plot
from .estimate import force_plot as force_plot
from .estimate import spectrum_plot as spectrum_plot
from .files import NAMES as NAMES
from .files import force_figure as force_figure
from .files import sweep_figure as sweep_figure
from .files import write_figures as write_figures
from .friction import friction_plot as friction_plot
from .matplotlib import drawn as drawn
from .plot import SHADED as SHADED
from .plot import NoPlot as NoPlot
from .plot import Panel as Panel
from .plot import Plot as Plot
from .plot import Series as Series
from .plot import drawable as drawable
from .result import record_plot as record_plot
from .result import result_plots as result_plots
from .result import sweep_plot as sweep_plot
from .result import tracking_plot as tracking_plot
