"""Derive the models of an axis.

In: `Axis`. Out: `AxisModel`, with the inverse and direct models, the map between their parameters,
the base parameters and the null space; and a description of the models in sentences. Knows nothing
of text files and of generated code.
"""

from .base_model import BaseModel as BaseModel, base_model as base_model
from .description import (
    Section as Section,
    derived_sections as derived_sections,
    describe_determined as describe_determined,
    describe_loss as describe_loss,
    describe_undecided as describe_undecided,
    describe_undetermined as describe_undetermined,
    describe_unidentifiable as describe_unidentifiable,
    undetermined_names as undetermined_names,
)
from .direct import ParameterMap as ParameterMap
from .friction_ladder import friction_ladder as friction_ladder
from .friction_states import (
    StateEquation as StateEquation,
    forces_at_rest as forces_at_rest,
    motion_point as motion_point,
    state_limits as state_limits,
)
from .model import AxisModel as AxisModel, derive as derive
from .null_space import (
    CommonParameter as CommonParameter,
    NullSpaceVector as NullSpaceVector,
    common_parameters as common_parameters,
    generic_points as generic_points,
    nominal_point as nominal_point,
)
