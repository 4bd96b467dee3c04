"""Estimates held against each other, their instruments and the motion that they are of.

In: estimates. Out: measured findings, each with a `Check`.
Knows nothing of the recorded loop.
"""

from .agreement import fixed_check as fixed_check
from .agreement import forms_check as forms_check
from .agreement import ls_against_iv as ls_against_iv
from .bounds import within_bounds as within_bounds
from .coarse_positions import coarse_positions as coarse_positions
from .drive_gain import gain_check as gain_check
from .excitation import Excitation as Excitation
from .excitation import excitation as excitation
from .excitation import excitation_of_several as excitation_of_several
from .instruments import NO_ENDOGENEITY as NO_ENDOGENEITY
from .instruments import Endogeneity as Endogeneity
from .instruments import InstrumentTests as InstrumentTests
from .instruments import Strength as Strength
from .instruments import biased_parameters as biased_parameters
from .instruments import endogeneity_of as endogeneity_of
from .instruments import instrument_tests as instrument_tests
from .instruments import strength_check as strength_check
from .instruments import tests_of_instruments as tests_of_instruments
from .motion import precision as precision
from .motion import precision_check as precision_check
from .nominal import NOMINAL_VALUES as NOMINAL_VALUES
from .nominal import nominal_check as nominal_check
from .second_opinion import prefers_instruments as prefers_instruments
from .second_opinion import second_opinion_check as second_opinion_check
