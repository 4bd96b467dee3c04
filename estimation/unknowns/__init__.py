"""What is searched: shared by records or local to one, known, bounded, and what else is free.

In: axes, forms, records, values known of each record. Out: `JointForm` of several records,
`ExtendedForm` with gains of drive and law, starts of loops or a time behind a model's parameters,
and `Unknowns` of a search. Knows nothing of estimates, outputs and how a search is made.
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
