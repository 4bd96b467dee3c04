"""Figures drawn by Matplotlib, and their files. Imported only where one is drawn.

In: `Plot`. Out: figures, files. Knows nothing of what a figure shows.
"""

from .files import NAMES as NAMES
from .files import force_figure as force_figure
from .files import sweep_figure as sweep_figure
from .files import write_figures as write_figures
from .matplotlib import draw as draw
from .matplotlib import draw_on as draw_on
