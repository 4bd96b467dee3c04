"""What commands use of the rooms below; `stages.py` imports a name when it is first used."""

from axisid.codegen.generated_axes import (
    MANIFEST as MANIFEST,
    GeneratedAxis as GeneratedAxis,
    build as build,
    check_files as check_files,
    expected_files as expected_files,
    write_files as write_files,
)
from axisid.estimation.control_law_search import find_law as find_law
from axisid.estimation.identification import (
    Identification as Identification,
    check_usable as check_usable,
    identify as identify,
    known_of_used as known_of_used,
)
from axisid.estimation.logs import log_endings as log_endings
from axisid.estimation.model_selection import (
    compare as compare,
    default_cutoffs as default_cutoffs,
    sweep as sweep,
)
from axisid.estimation.model_validation import Validation as Validation, validate as validate
from axisid.estimation.monte_carlo import (
    MonteCarlo as MonteCarlo,
    check_output as check_output,
    declared_chain as declared_chain,
    monte_carlo as monte_carlo,
    twin_of as twin_of,
    write_runs as write_runs,
)
from axisid.estimation.noise_models import Chain as Chain
from axisid.estimation.output_error import OutputFit as OutputFit, fit as fit
from axisid.estimation.records import (
    Record as Record,
    Repairs as Repairs,
    log_of as log_of,
    read_record as read_record,
    started_run as started_run,
)
from axisid.estimation.signals import FilteredRecord as FilteredRecord, Prefilter as Prefilter
from axisid.estimation.simulation import twin_record as twin_record
from axisid.estimation.unknowns import known_of as known_of
from axisid.estimation.verdict_checks import joined as joined
from axisid.exports import export as export
from axisid.fleets import (
    Trend as Trend,
    fleet as fleet,
    gather_items as gather_items,
    trend as trend,
    written_files as written_files,
)
from axisid.modeling.declaration import (
    Axis as Axis,
    Move as Move,
    back_and_forth as back_and_forth,
    fix as fix,
    leave_out as leave_out,
    read_fixed as read_fixed,
)
from axisid.modeling.derivation import derive as derive, friction_ladder as friction_ladder
from axisid.modeling.library import LIBRARY as LIBRARY
from axisid.modeling.parsing import load_axis as load_axis
from axisid.modeling.quantities import check_name as check_name
from axisid.paper import (
    DISTRIBUTION_FILES as DISTRIBUTION_FILES,
    STUDY_FILES as STUDY_FILES,
    distributions_document as distributions_document,
    run_distributions as run_distributions,
    run_study as run_study,
    study_document as study_document,
    write_distributions as write_distributions,
    write_study as write_study,
)
from axisid.presentation.documents import (
    Document as Document,
    axis_document as axis_document,
    axis_page as axis_page,
)
from axisid.presentation.matplotlib import (
    NAMES as NAMES,
    sweep_figure as sweep_figure,
    write_figures as write_figures,
)
from axisid.presentation.page import (
    fit_report_html as fit_report_html,
    monte_carlo_page as monte_carlo_page,
    write_outputs as write_outputs,
)
from axisid.presentation.plots import (
    PLOTS as PLOTS,
    Plot as Plot,
    monte_carlo_plots as monte_carlo_plots,
)
from axisid.presentation.result_files import compare_results as compare_results
from axisid.presentation.text import missing_notes as missing_notes
from axisid.presentation.views import as_blocks as as_blocks
from axisid.twins import (
    TwinMachines as TwinMachines,
    twin_files as twin_files,
    write_twin as write_twin,
    write_twins as write_twins,
)
