"""Estimates held against each other, their instruments and the motion that they are of.

In: estimates. Out: measured findings, each with a `Check`.
Knows nothing of the recorded loop.
"""

from .excitation import (
    NOMINAL_VALUES as NOMINAL_VALUES,
    Excitation as Excitation,
    excitation as excitation,
    fixed_check as fixed_check,
    gain_check as gain_check,
    held_check as held_check,
    nominal_check as nominal_check,
    precision as precision,
    precision_check as precision_check,
    within_bounds as within_bounds,
)
from .method import (
    FORMS as FORMS,
    LESS as LESS,
    LS_LESS_IV as LS_LESS_IV,
    SECOND_OPINION as SECOND_OPINION,
    InstrumentTests as InstrumentTests,
    Strength as Strength,
    forms_check as forms_check,
    method_check as method_check,
    moved_by_steps as moved_by_steps,
    strength_check as strength_check,
    tests_of_instruments as tests_of_instruments,
    vaguer as vaguer,
)
