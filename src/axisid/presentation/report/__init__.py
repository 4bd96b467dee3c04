"""The report: one page of HTML with everything in it, for a colleague.

In: an identification or a fit. Out: a page. Knows nothing of how statistics are computed.
"""

from .fit_page import fit_report_html as fit_report_html
from .outputs import write_outputs as write_outputs
from .page import figures_html as figures_html, model_html as model_html, page_of as page_of
from .provenance import facts_html as facts_html, made_text as made_text
