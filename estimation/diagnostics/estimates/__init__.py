"""Estimates held against each other, their instruments and the motion that they are of.

In: estimates. Out: measured findings, each with a `Check`.
Knows nothing of the recorded loop.
"""

from .bounds import within_bounds as within_bounds
from .drive_gain import gain_check as gain_check
from .excitation import Excitation as Excitation
from .excitation import excitation as excitation
from .excitation import excitation_of_several as excitation_of_several
from .fixed_values import fixed_check as fixed_check
from .instruments import InstrumentTests as InstrumentTests
from .instruments import Strength as Strength
from .instruments import strength_check as strength_check
from .instruments import tests_of_instruments as tests_of_instruments
from .method import FORMS as FORMS
from .method import LESS as LESS
from .method import LS_LESS_IV as LS_LESS_IV
from .method import SECOND_OPINION as SECOND_OPINION
from .method import forms_check as forms_check
from .method import method_check as method_check
from .method import moved_by_steps as moved_by_steps
from .method import prefers_instruments as prefers_instruments
from .motion import precision as precision
from .motion import precision_check as precision_check
from .nominal import NOMINAL_VALUES as NOMINAL_VALUES
from .nominal import nominal_check as nominal_check
