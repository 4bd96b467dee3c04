"""Whether residuals are noise, and what they are made of where they are not.

In: an estimate, the rows that it was made from. Out: measured findings, each with a `Check`.
Knows nothing of other estimates.
"""

from .lack_of_fit import lack_of_fit_check as lack_of_fit_check
from .missing import (
    outliers_check as outliers_check,
    signals_check as signals_check,
    terms_check as terms_check,
)
