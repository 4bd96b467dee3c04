"""Results as plain data: written as JSON, described by a schema, and read back.

In: a result, or a JSON file. Out: its document; results read from files that can be summarised,
drawn, validated and exported like live ones; the JSON schema. Knows nothing of how statistics are
computed.
"""

from .checks import read_checks as read_checks
from .diagnosis import (
    WrittenAlignment as WrittenAlignment,
    WrittenLawCheck as WrittenLawCheck,
)
from .estimate import (
    SavedEstimate as SavedEstimate,
    written_estimate as written_estimate,
)
from .file import (
    FittedAxis as FittedAxis,
    fitted_axis as fitted_axis,
    load_result as load_result,
)
from .identification import (
    SavedIdentification as SavedIdentification,
    WrittenIdentification as WrittenIdentification,
    WrittenMember as WrittenMember,
    identification_facts as identification_facts,
    written_identification as written_identification,
)
from .json_objects import (
    JsonObject as JsonObject,
    Matrix as Matrix,
    about as about,
    plain as plain,
    schema_of as schema_of,
)
from .output_fit import (
    SavedFitValidation as SavedFitValidation,
    SavedOutputFit as SavedOutputFit,
    written_fit_validation as written_fit_validation,
    written_output_fit as written_output_fit,
)
from .record import written_record as written_record
from .result_comparison import (
    ResultComparison as ResultComparison,
    compare_results as compare_results,
    result_comparison_document as result_comparison_document,
)
from .results_schema import results_schema as results_schema
from .studies import (
    SavedMonteCarlo as SavedMonteCarlo,
    written_comparison as written_comparison,
    written_law_search as written_law_search,
    written_study as written_study,
    written_sweep as written_sweep,
    written_validation as written_validation,
)
