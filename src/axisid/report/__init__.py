"""The report: one page of HTML with everything in it, for a colleague."""

from .outputs import Outputs as Outputs
from .page import report_html as report_html
from .page import report_sweep as report_sweep
