"""Least squares of logs that are larger than memory, in one pass.

In: an axis, blocks of samples. Out: `StreamedEstimate`. Knows nothing of simulated loops, which
instruments need, and of how it is shown.
"""

from .identify_stream import identify_stream as identify_stream
from .streamed_estimate import StreamedEstimate as StreamedEstimate
