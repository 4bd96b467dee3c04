from .batched import (
    LaneEstimates as LaneEstimates,
    RecordLanes as RecordLanes,
    identify_lanes as identify_lanes,
)
from .control_law_search import (
    ExplainedLaw as ExplainedLaw,
    LawSearch as LawSearch,
    find_law as find_law,
)
from .diagnostics import (
    Alignment as Alignment,
    Diagnosis as Diagnosis,
    Excitation as Excitation,
    estimate_delay as estimate_delay,
)
from .diagnostics.control_law import LawAgreement as LawAgreement, law_agreement as law_agreement
from .estimates import Iterate as Iterate, Value as Value
from .identification import DriveTime as DriveTime
from .methods import METHODS as METHODS
from .misspecification import (
    JackknifeInterval as JackknifeInterval,
    LackOfFit as LackOfFit,
)
from .model_selection import (
    Candidate as Candidate,
    Comparison as Comparison,
    Sweep as Sweep,
    default_cutoffs as default_cutoffs,
)
from .model_validation import (
    FitValidation as FitValidation,
    MethodValidation as MethodValidation,
    Validation as Validation,
    validate_fit as validate_fit,
)
from .monte_carlo import (
    CheckFigures as CheckFigures,
    Estimand as Estimand,
    EstimandFigures as EstimandFigures,
    FailedRun as FailedRun,
    Mean as Mean,
    MonteCarlo as MonteCarlo,
    MonteCarloPlan as MonteCarloPlan,
    Share as Share,
    write_runs as write_runs,
)
from .noise_models import Chain as Chain
from .output_error import OutputFit as OutputFit
from .raw_tables import Provenance as Provenance, Repair as Repair
from .records import Repairs as Repairs
from .regression import (
    Classical as Classical,
    DrawSummary as DrawSummary,
    Hac as Hac,
    PublishedCovariance as PublishedCovariance,
    ResidualTests as ResidualTests,
    Robust as Robust,
    delta_method as delta_method,
)
from .signals import FilteredRecord as FilteredRecord, SampledFilter as SampledFilter
from .simulation import (
    BatchSimulation as BatchSimulation,
    Simulation as Simulation,
    simulate_batch as simulate_batch,
)
from .verdict_checks import Check as Check, Levels as Levels
