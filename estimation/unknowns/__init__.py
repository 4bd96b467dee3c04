"""Unknowns of a search: shared or local parameters, bounds, priors, fixed values, nuisance ones.

In: axes, forms, records, known values of each record. Out: `JointForm` of several records,
`ExtendedForm` with nuisance parameters (gains of drive and law, starts of loops, a time of the
drive), and `Unknowns` of a search. Knows nothing of estimates, outputs and search algorithms.
"""

from .bounds_and_priors import (
    BoundOrNone as BoundOrNone,
    Unknowns as Unknowns,
    bounded_quadratic_minimum as bounded_quadratic_minimum,
    check_enough as check_enough,
    unknowns_of as unknowns_of,
)
from .joint_parameters import (
    GAIN as GAIN,
    JointForm as JointForm,
    declared_names as declared_names,
    joint_form_of as joint_form_of,
    perturbed_joint_forms as perturbed_joint_forms,
)
from .known_values import (
    KnownValue as KnownValue,
    KnownValues as KnownValues,
    known_of as known_of,
)
from .nuisance_parameters import (
    INITIAL_STATE_PARAMETERS as INITIAL_STATE_PARAMETERS,
    START as START,
    ExtendedForm as ExtendedForm,
    axis_at as axis_at,
    by_declared_gain as by_declared_gain,
    gains_in as gains_in,
    inputs_at as inputs_at,
    least_sizes as least_sizes,
    started_at as started_at,
)
