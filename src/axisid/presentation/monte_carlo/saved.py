"""A study that was read from its file, by the presenter of a live one."""

from typing import Any, cast

from msgspec import UnsetType

from axisid.estimation.monte_carlo import MonteCarlo, declared_chain
from axisid.estimation.twins import Chain
from axisid.presentation.blocks import Document
from axisid.presentation.saved import Like, SavedMonteCarlo
from axisid.support.remedy import Wording, as_arguments

from .document import monte_carlo_document


def saved_study_document(saved: SavedMonteCarlo, *, wording: Wording = as_arguments) -> Document:
    """As of a study that was just made."""
    return monte_carlo_document(_live(saved), wording=wording)


def _live(saved: SavedMonteCarlo) -> MonteCarlo:
    """What the presenter of a study reads of one."""
    written, twins = saved.document, saved.document.twins
    twin = Like(
        name=twins.axis,
        coordinate=Like(unit=twins.unit),
        drive=Like(unit=twins.drive_unit),
    )
    noise = twins.chain
    if isinstance(noise, UnsetType):
        experiment = Chain(position=twins.position_noise, position_step=twins.resolution)
        noise = declared_chain(experiment, **cast(Any, twins.noise))
    plan = Like(
        axis=Like(axis=Like(name=written.axis)),
        twin=Like(axis=twin),
        noise=noise,
        runs=written.runs,
        seed=written.seed,
        methods=written.methods,
        chosen=saved.chosen,
        is_right=twins.right,
    )
    return cast(MonteCarlo, Like(saved, plan=plan))
