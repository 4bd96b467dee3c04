"""Output error: parameters with which a simulated output follows the recorded one.

In: an axis, records, an output. Out: `OutputFit`.
Knows nothing of filters beyond those of its start, and nothing of how it is shown.
"""

from .fit import fit as fit
from .fit_setup import checked_horizon as checked_horizon
from .inference import FittedParameters as FittedParameters
from .result import OutputFit as OutputFit, RecordError as RecordError
