"""A Monte-Carlo study as text, figures, plain data and a page.

In: `MonteCarlo`. Out: a document of blocks, plots, what JSON has, a page.
Knows nothing of how twins are made.
"""

from .document import (
    estimand_tables as estimand_tables,
    findings as findings,
    legend as legend,
    study_document as study_document,
    study_facts as study_facts,
    written_study as written_study,
)
from .plots import (
    PLOTS as PLOTS,
    monte_carlo_page as monte_carlo_page,
    monte_carlo_plot as monte_carlo_plot,
    monte_carlo_plots as monte_carlo_plots,
)
