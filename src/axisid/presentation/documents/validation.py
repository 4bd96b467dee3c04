"""Estimates held against another record, as a document."""

from axisid.estimation.studies import MethodValidation, Validation
from axisid.presentation.schema import WrittenMethodValidation, WrittenValidation
from axisid.support.arrays import finite_tree

from .diagnosis import written_law
from .identification import note_text, written_record


def written_validation(validation: Validation) -> WrittenValidation:
    """Errors by method; what is not finite becomes None."""
    return WrittenValidation(
        belief=validation.belief,
        record=written_record(validation.record),
        methods=tuple(map(_method, validation)),
        time_base=note_text(validation.time_base),
        law_check=written_law(validation.law),
        holds=validation.holds,
    )


def _method(validation: MethodValidation) -> WrittenMethodValidation:
    v, again = validation, validation.reestimate
    return WrittenMethodValidation(
        method=v.method,
        equation_error_percent=finite_tree(v.equation_error_percent),
        own_equation_error_percent=finite_tree(v.own_equation_error_percent),
        simulation_error_percent=finite_tree(v.simulation_error_percent),
        position_error_rms=finite_tree(v.position_error_rms),
        tracking_error_percent=finite_tree(v.tracking_error_percent),
        reason=note_text(v.reason) or "",
        holds=v.holds,
        own_simulation_error_percent=finite_tree(v.own_simulation_error_percent),
        own_tracking_error_percent=finite_tree(v.own_tracking_error_percent),
        anew=None
        if again is None
        else finite_tree(dict(zip(again.names, again.physical.tolist(), strict=True))),
        anew_distances=None
        if again is None
        else finite_tree(dict(zip(again.names, again.distances.tolist(), strict=True))),
        anew_share_percent=None if again is None else finite_tree(again.share_percent),
    )
