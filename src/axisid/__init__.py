"""axisid: from the equation of motion of a one-degree-of-freedom axis to trustworthy parameters.

Declare an axis with `newton` or `lagrange` (or take one of the library with `load_axis`), read a
record, choose a `Prefilter`, `identify`. Names are imported when first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from axisid.codegen import GeneratedAxis as GeneratedAxis
    from axisid.codegen import build as build
    from axisid.estimation import METHODS as METHODS
    from axisid.estimation import BatchSimulation as BatchSimulation
    from axisid.estimation import Comparison as Comparison
    from axisid.estimation import DataError as DataError
    from axisid.estimation import Estimate as Estimate
    from axisid.estimation import EstimationError as EstimationError
    from axisid.estimation import Identification as Identification
    from axisid.estimation import LogBlocks as LogBlocks
    from axisid.estimation import Prefilter as Prefilter
    from axisid.estimation import Record as Record
    from axisid.estimation import Repairs as Repairs
    from axisid.estimation import Simulation as Simulation
    from axisid.estimation import Sweep as Sweep
    from axisid.estimation import compare as compare
    from axisid.estimation import delta_method as delta_method
    from axisid.estimation import identify as identify
    from axisid.estimation import identify_stream as identify_stream
    from axisid.estimation import read_record as read_record
    from axisid.estimation import simulate as simulate
    from axisid.estimation import simulate_batch as simulate_batch
    from axisid.estimation import sweep as sweep
    from axisid.estimation import twin_record as twin_record
    from axisid.estimation import validate as validate
    from axisid.exports import export as export
    from axisid.modeling import LIBRARY as LIBRARY
    from axisid.modeling import MEASURED_POSITION as MEASURED_POSITION
    from axisid.modeling import MEASURED_VELOCITY as MEASURED_VELOCITY
    from axisid.modeling import PERIOD as PERIOD
    from axisid.modeling import REFERENCE as REFERENCE
    from axisid.modeling import Axis as Axis
    from axisid.modeling import AxisidError as AxisidError
    from axisid.modeling import AxisModel as AxisModel
    from axisid.modeling import Constant as Constant
    from axisid.modeling import ControlLaw as ControlLaw
    from axisid.modeling import Coordinate as Coordinate
    from axisid.modeling import Drive as Drive
    from axisid.modeling import Experiment as Experiment
    from axisid.modeling import G as G
    from axisid.modeling import Memory as Memory
    from axisid.modeling import ModelError as ModelError
    from axisid.modeling import Move as Move
    from axisid.modeling import Parameter as Parameter
    from axisid.modeling import UsageError as UsageError
    from axisid.modeling import asymmetric_coulomb as asymmetric_coulomb
    from axisid.modeling import asymmetric_viscous as asymmetric_viscous
    from axisid.modeling import back_and_forth as back_and_forth
    from axisid.modeling import cascade_pd as cascade_pd
    from axisid.modeling import cascade_pd_averaged as cascade_pd_averaged
    from axisid.modeling import cascade_pd_difference as cascade_pd_difference
    from axisid.modeling import cogging as cogging
    from axisid.modeling import coulomb as coulomb
    from axisid.modeling import cubic_spring as cubic_spring
    from axisid.modeling import derive as derive
    from axisid.modeling import end_stop as end_stop
    from axisid.modeling import fix as fix
    from axisid.modeling import friction_ladder as friction_ladder
    from axisid.modeling import gain as gain
    from axisid.modeling import gravity as gravity
    from axisid.modeling import gravity_moment as gravity_moment
    from axisid.modeling import lagrange as lagrange
    from axisid.modeling import leave_out as leave_out
    from axisid.modeling import load_axis as load_axis
    from axisid.modeling import load_dependent as load_dependent
    from axisid.modeling import motor_inertia as motor_inertia
    from axisid.modeling import newton as newton
    from axisid.modeling import offset as offset
    from axisid.modeling import periodic_coulomb as periodic_coulomb
    from axisid.modeling import quadratic as quadratic
    from axisid.modeling import spring as spring
    from axisid.modeling import stribeck as stribeck
    from axisid.modeling import viscous as viscous

# The same names by stage: a test compares this table with the imports above.
_STAGES = {
    "axisid.modeling": (
        "Axis AxisModel AxisidError Constant ControlLaw Coordinate Drive Experiment G LIBRARY "
        "MEASURED_POSITION MEASURED_VELOCITY Memory ModelError Move PERIOD Parameter REFERENCE "
        "UsageError asymmetric_coulomb asymmetric_viscous back_and_forth cascade_pd "
        "cascade_pd_averaged cascade_pd_difference cogging coulomb cubic_spring derive end_stop "
        "fix friction_ladder gain gravity gravity_moment lagrange leave_out load_axis "
        "load_dependent motor_inertia newton offset periodic_coulomb quadratic spring stribeck "
        "viscous"
    ),
    "axisid.codegen": "GeneratedAxis build",
    "axisid.estimation": (
        "BatchSimulation Comparison DataError Estimate EstimationError Identification "
        "LogBlocks METHODS Prefilter Record Repairs Simulation Sweep compare delta_method identify "
        "identify_stream read_record simulate simulate_batch sweep twin_record validate"
    ),
    "axisid.exports": "export",
}
_HOME = {name: stage for stage, names in _STAGES.items() for name in names.split()}

__all__ = ["__version__", *sorted(_HOME)]  # noqa: PLE0604


def __getattr__(name: str) -> Any:
    """Import a public name from its stage when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module 'axisid' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
