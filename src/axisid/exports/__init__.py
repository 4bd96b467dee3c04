"""Estimates for other programs: feed-forward functions and tables.

In: an identification or a file of one. Out: text.
"""

from .export import export as export
