"""What is searched: shared by records or local to one, known, bounded, and what else is free.

In: axes, forms, records, values known of each record. Out: `Layout` and `JointForm` of several
records, forms with gains of drive and law, starts of loops or a time behind a model's parameters,
and `Unknowns` of a search. Knows nothing of estimates, outputs and how a search is made.
"""

from .drive_gain import FormByDriveGain as FormByDriveGain
from .drive_gain import by_declared_gain as by_declared_gain
from .form import JointForm as JointForm
from .known import Known as Known
from .known import Told as Told
from .known import known_of as known_of
from .known import read_known as read_known
from .layout import GAIN as GAIN
from .layout import Layout as Layout
from .layout import layout_of as layout_of
from .layout import moved_layouts as moved_layouts
from .nuisance import START as START
from .nuisance import STARTS as STARTS
from .nuisance import FormByGains as FormByGains
from .nuisance import FormByStart as FormByStart
from .nuisance import FormByTime as FormByTime
from .nuisance import are_starts as are_starts
from .nuisance import axis_at as axis_at
from .nuisance import gains_in as gains_in
from .nuisance import inputs_at as inputs_at
from .nuisance import least_sizes as least_sizes
from .nuisance import start_sizes as start_sizes
from .nuisance import started_at as started_at
from .prefilters import prefilters_of as prefilters_of
from .unknowns import End as End
from .unknowns import Unknowns as Unknowns
from .unknowns import by_name as by_name
from .unknowns import check_enough as check_enough
from .unknowns import least_within as least_within
from .unknowns import unknowns_of as unknowns_of
