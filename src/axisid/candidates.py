"""What `identify` and `fit` look for beside a model, and where a row of one's own is added.

A candidate is a `Term`: what it is called, what to declare, and the columns that it has along a
motion. ``TERMS["ripple"] = Term(kind="ripple", ...)`` is looked for from then on.
"""

from axisid.estimation.lacking.terms import TERMS as TERMS
from axisid.estimation.lacking.terms import Along as Along
from axisid.estimation.lacking.terms import Term as Term
