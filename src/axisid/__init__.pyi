from . import (
    candidates as candidates,
    codegen as codegen,
    control as control,
    elements as elements,
    estimation as estimation,
    modeling as modeling,
)
from .codegen.generated_axes import build as build
from .estimation.estimates import Estimate as Estimate
from .estimation.identification import Identification as Identification, identify as identify
from .estimation.model_selection import compare as compare, sweep as sweep
from .estimation.model_validation import validate as validate
from .estimation.monte_carlo import monte_carlo as monte_carlo
from .estimation.output_error import fit as fit
from .estimation.records import Record as Record, read_record as read_record
from .estimation.signals import Prefilter as Prefilter
from .estimation.simulation import simulate as simulate, twin_record as twin_record
from .exports import export as export
from .fleets import FleetItem as FleetItem, fleet as fleet, trend as trend
from .modeling.declaration import (
    Axis as Axis,
    fix as fix,
    lagrange as lagrange,
    leave_out as leave_out,
    newton as newton,
)
from .modeling.derivation import derive as derive, friction_ladder as friction_ladder
from .modeling.parsing import load_axis as load_axis
from .modeling.quantities import (
    Constant as Constant,
    Coordinate as Coordinate,
    Parameter as Parameter,
    Signal as Signal,
)
from .presentation.result_files import (
    compare_results as compare_results,
    load_result as load_result,
)
from .support.errors import (
    AxisidError as AxisidError,
    DataError as DataError,
    EstimationError as EstimationError,
    ModelError as ModelError,
    UsageError as UsageError,
)
from .support.version import __version__ as __version__
