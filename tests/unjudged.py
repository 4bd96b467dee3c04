"""`identify` as tests of estimates need it: a verdict is computed where a test reads it."""

from functools import partial

import axisid

identify = partial(axisid.identify, judge=False)
