"""Results of one axis over time, or of many axes: limits, what is beyond them, steps.

In: files of results. Out: series with their charts, as text, a page, a table. Knows nothing of
how a result is made, and of the command line.
"""

from .trend import Trend as Trend, trend as trend
