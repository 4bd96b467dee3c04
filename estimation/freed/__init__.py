"""Parameters of a model with what else is free: gains of drive and law, starts of loops, a time.

In: a form, axes, records, names. Out: a `Form` with more physical parameters behind its own.
Knows nothing of outputs, and nothing of how parameters are searched for.
"""

from .drive_gain import FormByDriveGain as FormByDriveGain
from .drive_gain import by_declared_gain as by_declared_gain
from .gains import FormByGains as FormByGains
from .gains import axis_at as axis_at
from .gains import gains_in as gains_in
from .gains import inputs_at as inputs_at
from .start import START as START
from .start import STARTS as STARTS
from .start import FormByStart as FormByStart
from .start import are_starts as are_starts
from .start import least_sizes as least_sizes
from .start import start_sizes as start_sizes
from .start import started_at as started_at
from .time import FormByTime as FormByTime
