"""The report: one page of HTML with everything in it, for a colleague.

In: an identification. Out: a page. Computes no statistics.
"""

from .outputs import Outputs as Outputs
