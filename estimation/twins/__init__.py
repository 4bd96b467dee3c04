"""A record's loop once more, with noise as the record has it, and what estimates make of it.

In: a problem, an estimate of it. Out: the chain of noise that the record was measured through,
twins, and by them the estimate's bias and deviations. Knows nothing of methods and of verdicts.
"""

from .calibration import Calibration as Calibration
from .calibration import calibrated as calibrated
from .chain import Autoregressions as Autoregressions
from .chain import Chain as Chain
from .chain import Draws as Draws
from .measured_chain import measured_chain as measured_chain
from .twins import DEFAULT_COUNT as DEFAULT_COUNT
from .twins import Twins as Twins
from .twins import check_count as check_count
from .twins import twins_of as twins_of
