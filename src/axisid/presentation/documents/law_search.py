"""Which ready laws explain a recorded control, as plain data."""

from axisid.estimation.law_search import ExplainedLaw, LawSearch
from axisid.presentation.schema import WrittenExplainedLaw, WrittenLawSearch


def written_law_search(search: LawSearch) -> WrittenLawSearch:
    """What ``--json`` writes."""
    return WrittenLawSearch(
        belief=search.belief,
        axis=search.axis,
        unit=search.unit,
        explained=search.explained,
        as_well=search.as_well,
        laws=tuple(map(_law, search.laws)),
    )


def _law(each: ExplainedLaw) -> WrittenExplainedLaw:
    return WrittenExplainedLaw(
        law=each.function,
        words=dict(each.words),
        gains=dict(each.law.gains),
        sd=dict(each.deviations),
        delay=each.law.delay,
        period=each.law.period,
        held_out_percent=each.held_out_percent,
        fitted_percent=each.fitted_percent,
        same=each.same,
        toml=each.toml,
    )
