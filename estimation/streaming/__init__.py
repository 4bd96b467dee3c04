"""Logs that are larger than memory: least squares, and instruments of a loop that goes along.

In: an axis, blocks of samples. Out: `StreamedEstimate`. Knows nothing of checks of a whole record,
and of how it is shown.
"""

from .identify_stream import STREAMED_METHODS as STREAMED_METHODS
from .identify_stream import identify_stream as identify_stream
from .streamed_estimate import StreamedEstimate as StreamedEstimate
