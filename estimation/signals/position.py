"""Whether an axis can be identified from a record without its position."""

import numpy as np

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.records import Record
from axisid.support.errors import DataError
from axisid.support.remedy import Remedy, Setting

from .without_turns import dependence

_POSITION = 0  # among what the inverse model takes
_OF_DRIVE = 1  # among what the drive takes


def check_position(axis: GeneratedAxis, record: Record) -> None:
    """Refuse a record of velocity alone for an axis whose model needs the position.

    Raises
    ------
    DataError
        It does; what depends on the position is named.
    """
    if record.integrated:
        check_without_position(axis, record.provenance.source)


def check_without_position(axis: GeneratedAxis, source: str) -> None:
    """The same of a log that is known to have no position."""
    needing = _needing(axis)
    if not needing:
        return
    raise DataError(
        f"{source} has no position, on which {' and '.join(needing)} of axis {axis.axis.name!r} "
        f"depend{'s' * (len(needing) == 1)}; the integral of a measured velocity drifts. ",
        Remedy.of("Name it with ", Setting("columns", "position=NAME"), "."),
        code="no-position",
    )


def _needing(axis: GeneratedAxis) -> list[str]:
    """What of an axis depends on the position, in words."""
    columns = dependence(axis)["position"]
    found = [name for name, needs in zip(axis.names, columns, strict=True) if needs]
    if _depends(axis, "idm_regressor", 1, _POSITION):
        found.append("the known terms")
    if _depends(axis, "drive_force", 0, _OF_DRIVE):
        found.append("the force of the drive")
    return found


def _depends(axis: GeneratedAxis, name: str, output: int, place: int) -> bool:
    return bool(np.any(axis.functions[name].jac_sparsity(output, place).nnz()))
