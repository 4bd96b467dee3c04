"""Whether residuals are noise, and what they are made of where they are not.

In: an estimate, the rows that it was made from. Out: measured findings, each with a `Check`.
Knows nothing of other estimates.
"""

from .as_measured import following_as_measured as following_as_measured
from .as_measured import tails_as_measured as tails_as_measured
from .recorded_signals import signals_check as signals_check
from .residuals import normality as normality
from .residuals import residuals_against_motion as residuals_against_motion
from .unexplained import changes_check as changes_check
from .unexplained import constant_check as constant_check
from .unexplained import lack_of_fit_check as lack_of_fit_check
from .unexplained import terms_check as terms_check
