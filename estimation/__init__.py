"""From a record to estimates. Dimensions: N samples, n rows, p parameters, m of the direct model.

`Record` + `Prefilter` -> signals -> ``y``, ``X`` -> `Estimate`. No SymPy: the axis is its generated
functions.
"""

from .alignment import Alignment as Alignment
from .alignment import profile_alignment as profile_alignment
from .batch import BatchSimulation as BatchSimulation
from .batch import simulate_batch as simulate_batch
from .blocks import LogBlocks as LogBlocks
from .candidate import Candidate as Candidate
from .check import Check as Check
from .closed_loop import Simulation as Simulation
from .closed_loop import signals_before as signals_before
from .closed_loop import simulate as simulate
from .comparison import Comparison as Comparison
from .comparison import compare as compare
from .covariance import Classical as Classical
from .covariance import Covariance as Covariance
from .covariance import Hac as Hac
from .covariance import Published as Published
from .covariance import Robust as Robust
from .covariance import correlation as correlation
from .covariance import delta_method as delta_method
from .diagnosis import JUDGED as JUDGED
from .diagnosis import Diagnosis as Diagnosis
from .errors import DataError as DataError
from .errors import EstimationError as EstimationError
from .estimate import Estimate as Estimate
from .estimate import Iterate as Iterate
from .excitation import Excitation as Excitation
from .identification import METHODS as METHODS
from .identification import identify as identify
from .law_check import LawCheck as LawCheck
from .law_check import check_law as check_law
from .prefilter import Prefilter as Prefilter
from .propagation import Drawn as Drawn
from .provenance import Provenance as Provenance
from .provenance import Repair as Repair
from .readers import read_record as read_record
from .record import Record as Record
from .repairs import Repairs as Repairs
from .residual_tests import ResidualTests as ResidualTests
from .results import Identification as Identification
from .signals import Signals as Signals
from .signals import drive_force as drive_force
from .streamed import StreamedEstimate as StreamedEstimate
from .streaming import identify_stream as identify_stream
from .summary import text_table as text_table
from .sweep import Sweep as Sweep
from .sweep import default_cutoffs as default_cutoffs
from .sweep import sweep as sweep
from .twin import trajectory as trajectory
from .twin import twin_record as twin_record
from .validation import MethodValidation as MethodValidation
from .validation import Validation as Validation
from .validation import validate as validate
from .value import Value as Value
