"""What several records have in common, what each has for itself, and what is known of each.

In: an axis, values known of each record, names of parameters that are local. Out: `Layout`, which
places every record's rows in those of all, and `JointForm`, the regression in their parameters.
Knows nothing of estimates.
"""

from .form import JointForm as JointForm
from .known import Known as Known
from .known import Told as Told
from .known import known_of as known_of
from .known import read_known as read_known
from .layout import GAIN as GAIN
from .layout import Layout as Layout
from .layout import Member as Member
from .layout import drive_gain_of as drive_gain_of
from .layout import layout_of as layout_of
from .layout import moved_layouts as moved_layouts
from .prefilters import prefilters_of as prefilters_of
