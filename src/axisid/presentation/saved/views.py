"""A saved identification as a document and in figures, by the presenters of a live one."""

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from axisid.estimation.estimates import Estimate
from axisid.estimation.identification import Identification
from axisid.estimation.signals import Neighbours
from axisid.modeling.declaration import Drive
from axisid.modeling.quantities import Parameter, Signal
from axisid.presentation.blocks import Document
from axisid.presentation.plots import (
    Plot,
    autocorrelation_plot,
    convergence_plot,
    mean_residual_plot,
)
from axisid.presentation.schema import WrittenResponse
from axisid.presentation.text import estimate_document, identification_document
from axisid.support.errors import UsageError
from axisid.support.missing import Missing
from axisid.support.remedy import Wording, as_arguments
from axisid.support.user_values import is_among, quoted

from .drive import written_drive
from .estimate import SavedEstimate
from .identification import SavedIdentification

_PLOTS = {"autocorrelation": autocorrelation_plot, "convergence": convergence_plot}


class Like:
    """An object with some attributes of its own before another's.

    Presenters read attributes of a result; what a file does not hold they get from here: how many
    rows there were in place of the rows, an axis's name in place of the axis.
    """

    def __init__(self, other: object = None, **own: Any) -> None:
        vars(self).update(own)
        self._other = other

    def __getattr__(self, name: str) -> Any:
        return getattr(self._other, name)

    def __len__(self) -> int:
        return len(cast(Any, self._other))


def saved_document(
    saved: SavedIdentification,
    draws: int = 0,
    *,
    every: bool = False,
    full: bool = False,
    wording: Wording = as_arguments,
) -> Document:
    """Heading, tables, verdict and notes; see `SavedIdentification.summary`."""
    return identification_document(_live(saved), draws, every=every, full=full, wording=wording)


def saved_estimate_document(estimate: SavedEstimate) -> Document:
    """Every parameter with its deviation and interval, and the errors."""
    return estimate_document(_live_estimate(estimate))


def saved_plot(estimate: SavedEstimate, what: str) -> Plot | Missing:
    """A figure whose data the file holds.

    Raises
    ------
    UsageError
        It needs the rows of the record.
    """
    if not is_among(what, _PLOTS):
        raise UsageError(
            f"the file of a result has no rows of its record, which the figure {quoted(what)} "
            f"needs; identify again, or choose from {', '.join(_PLOTS)}.",
            code="no-saved-rows",
        )
    return _PLOTS[what](_live_estimate(estimate))


def saved_repeats_plot(saved: SavedIdentification) -> Plot:
    """The mean residual over a period; a `UsageError` where nothing repeated."""
    found = saved.diagnosis.lack_of_fit
    if found is None:
        raise UsageError("the file of a result has no residuals that repeat.")
    judged = saved.preferred
    return mean_residual_plot(found, judged.method, "", judged.row_period, left=judged.form.left)


def _live(saved: SavedIdentification) -> Identification:
    """What presenters of an identification read of one."""
    estimates = {name: _live_estimate(each) for name, each in saved.estimates.items()}
    record = Like(saved.record, force=True if saved.record.has_force else None)
    own = {"axis": _axis(saved), "record": record, "estimates": estimates}
    return cast(Identification, Like(saved, data=Like(sampling=saved.sampling), **own))


def _live_estimate(estimate: SavedEstimate) -> Estimate:
    rows = np.arange(estimate.document.rows, dtype=np.float64)
    own = {
        "y": rows,
        "rows": rows,
        "neighbours": Neighbours.consecutive(len(rows)),
        "period": estimate.row_period,
    }
    return cast(Estimate, Like(estimate, **own))


def _axis(saved: SavedIdentification) -> Like:
    """Names and units, of the declaration or as far as the file has them."""
    first = next(iter(saved.estimates.values()))
    units = {name: v.unit for name, v in first.parameters.items()}
    combined = {name: made for p in saved.physical.values() for name, made in _made(p).items()}
    declared = saved.declared
    # The file alone has the drive's force in words.
    written = saved.document.drive
    drive = Drive(gain=1.0) if declared is None else declared.drive
    if declared is None and isinstance(written, WrittenResponse):
        drive = written_drive(written)
    if declared is None:
        drive = cast(Drive, _told(saved, drive))
    if declared is None:
        left_out = tuple(
            Parameter(name, "1", known=value)
            for name, value in (saved.document.left_out or {}).items()
        )
        own = tuple(Parameter(name, unit) for name, unit in units.items() if name not in combined)
        declared = cast(Any, Like(left_out=left_out, parameters=own, title=""))
    signals = tuple(Signal(s.name, s.unit, s.between) for s in saved.document.signals or ())
    return Like(
        axis=Like(name=saved.name, title=declared.title, drive=drive, signals=signals),
        declared=declared,
        base=Like(combined=tuple(combined.values())),
        parameters=first.quantities,
        signature=saved.signature,
    )


def _told(saved: SavedIdentification, drive: Drive) -> Like:
    """A drive as far as the file has it."""
    force, remark = saved.document.drive_force, saved.document.drive_remark
    return Like(drive, is_gain=not force, remark=remark or "")


def _made(physical: Any) -> Mapping[str, tuple[Parameter, str]]:
    return {parameter.name: (parameter, made) for parameter, made in physical.base.combined}
