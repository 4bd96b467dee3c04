"""The report: one page of HTML with everything in it, for a colleague.

In: an identification, a fit or a study. Out: a page. Knows nothing of how statistics are computed.
"""

from .page import (
    fit_report_html as fit_report_html,
    monte_carlo_page as monte_carlo_page,
    write_outputs as write_outputs,
)
