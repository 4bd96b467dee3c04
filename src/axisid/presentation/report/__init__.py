"""The report: one page of HTML with everything in it, for a colleague.

In: an identification. Out: a page. Knows nothing of how statistics are computed.
"""

from .outputs import Outputs as Outputs
