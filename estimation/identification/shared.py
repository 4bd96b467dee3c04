"""The records that are used of those that were given, and what they share."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices import ROW_LOSSES, check_among
from axisid.estimation.parameters import JointForm, Told
from axisid.estimation.problems import Problem, check_time_known
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.support.errors import UsageError
from axisid.support.remedy import Note, Remedy, Setting
from axisid.support.user_values import quoted

from .bound import bound_records, layout_for, tells_gain, weighted
from .set_aside import layout_without, usable_records


@dataclass(frozen=True, slots=True, kw_only=True)
class Shared:
    """Records that are used, what is each one's own, and what is known of each.

    Attributes
    ----------
    axis : GeneratedAxis
        That was asked of.
    own_layout : JointForm or None
        Its own.
    records : tuple of Record
    local : tuple of str
    known : mapping of str to sequence
        As `identify` takes it.
    commanded : bool
        Whether a known force may tell the drive gain.
    set_aside : mapping of str to Note
        Records that are not used, with the reason.
    """

    axis: GeneratedAxis
    own_layout: JointForm | None
    records: tuple[Record, ...]
    local: tuple[str, ...]
    known: Mapping[str, Sequence[Told]]
    commanded: bool
    set_aside: Mapping[str, Note]

    def layout(self, axis: GeneratedAxis) -> JointForm | None:
        """How the parameters of an axis are shared; None where all are, of all records.

        A candidate may be without a parameter that others have for each record.

        Raises
        ------
        UsageError, ModelError
            As `layout_of` does.
        """
        if axis is self.axis:
            return self.own_layout
        declared = [p.name for p in axis.declared.parameters]
        own = [name for name in self.local if name in declared]
        return layout_for(axis, len(self.records), own, self.known, commanded=self.commanded)

    def axes(self, axis: GeneratedAxis, layout: JointForm | None) -> list[GeneratedAxis]:
        """That of each record, with what is known of it put in."""
        return [axis] * len(self.records) if layout is None else [m.axis for m in layout.members]

    def problem(
        self, axis: GeneratedAxis, prefilter: Prefilter, loss: str = ROW_LOSSES[0]
    ) -> Problem:
        """The records under a prefilter, each of its own axis, weighted by its own noise."""
        layout = self.layout(axis)
        into = () if layout is None else [*map(layout.slopes, range(len(self.records)))]
        data = bound_records(self.axes(axis, layout), self.records, prefilter, into)
        return weighted(Problem(axis=axis, data=data, layout=layout), loss)


def shared_records(
    axis: GeneratedAxis,
    records: Sequence[Record],
    prefilter: Prefilter | None,
    local: object,
    known: Mapping[str, Sequence[Told]] | None,
    gain: str,
    *,
    skip_bad: bool,
) -> Shared:
    """The records that a prefilter serves, or all without one, and what is said of each.

    Parameters
    ----------
    axis : GeneratedAxis
        Of which names are checked, and what is not identified without records that are set aside.
    records : sequence of Record
    prefilter : Prefilter or None
        None where records are not filtered.
    local, known, gain, skip_bad
        As of `identify`.

    Raises
    ------
    UsageError, ModelError
        Records cannot be used, and are not to be skipped; a name is none; or what is known is not
        of each record.
    """
    own = _names("local", local)
    check_among(("gain", gain, ("identified", "declared")))
    check_time_known(axis)
    if not isinstance(skip_bad, bool):
        raise UsageError(
            f"skip_bad is {quoted(skip_bad)}; give True or False.", code="skip-bad-type"
        )
    if own and len(records) == 1:
        raise UsageError(
            f"{', '.join(own)} {'is' if len(own) == 1 else 'are'} to be each record's own, and "
            "there is 1 record; ",
            Remedy.of("give several, or ", Setting("local", given=False), "."),
            code="local-of-one",
        )
    commanded = tells_gain(records, gain)
    whole = layout_for(axis, len(records), own, known, commanded=commanded)
    used, aside = usable_records(axis, records, prefilter, skip_bad=skip_bad)
    layout, own, known, aside = layout_without(
        axis, whole, used, aside, own, known, commanded=commanded
    )
    return Shared(
        axis=axis,
        own_layout=layout,
        records=tuple(records[i] for i in used),
        local=own,
        known=known,
        commanded=commanded,
        set_aside=aside,
    )


def _names(what: str, names: object) -> tuple[str, ...]:
    """Names that were given as one text or several."""
    if isinstance(names, str):
        return (names,) if names else ()
    if not isinstance(names, Iterable) or not all(isinstance(name, str) for name in names):
        raise UsageError(
            f"{what} is {quoted(names)}; give the names of parameters.", code="names-type"
        )
    return tuple(names)
