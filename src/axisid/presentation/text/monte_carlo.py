"""A study as tables: bias, scatter and intervals, and what checks say."""

import math
from collections.abc import Sequence

from axisid.estimation.choices import fitted_output
from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.monte_carlo import (
    COLOURED,
    DIRECT,
    MODEL_ERROR,
    PARAMETER,
    PHYSICAL,
    CheckFigures,
    EstimandFigures,
    Mean,
    Share,
    interval_covariance,
)
from axisid.estimation.noise_models import noise_sources
from axisid.estimation.thresholds import INTERVAL_LEVEL
from axisid.presentation.documents import (
    Block,
    Cell,
    Document,
    Heading,
    Paragraph,
    QuantityCell,
    TableBlock,
    TableColumn,
    decimals,
    figure_text,
    paragraph,
    text_columns,
)
from axisid.presentation.plots import method_title
from axisid.presentation.result_files import SavedMonteCarlo
from axisid.presentation.sentences import sentence

_PLAIN = (1e-6, 1e6)  # errors between which figures have no power of ten

_LABELS = {MODEL_ERROR: "model error", COLOURED: "coloured errors"}
_TITLES = {
    PARAMETER: "Estimates",
    DIRECT: "Parameters of the direct model",
    PHYSICAL: "Declared parameters that follow",
}


def study_document(result: SavedMonteCarlo) -> Document:
    """What was done, the estimates by method, the checks, and what came to nothing."""
    return (
        Heading(facts=heading_facts(result)),
        *estimand_tables(result),
        *([study_checks(result)] if result.judged else []),
        legend(result),
        findings(result),
    )


def heading_facts(result: SavedMonteCarlo) -> dict[str, str]:
    """What was done in each run."""
    twins, noise = result.twins, result.noise
    begun = ", begun anywhere in a count" if noise.anywhere else ""
    done = f"{len(result)}" if len(result) == result.runs else f"{len(result)} of {result.runs}"
    return {
        "axis": result.name,
        "twins": f"{done} twins of {twins.axis}, seed {result.seed}",
        "noise": sentence(noise_sources(noise, twins.unit, twins.drive_unit)) + begun,
        "model": "the twins' own" if twins.right else "another than the twins'",
        "methods": ", ".join(map(method_title, result.methods)),
        "intervals": f"{100 * INTERVAL_LEVEL.value:g} %, {_stated_labels(result)}",
    }


def estimand_tables(result: SavedMonteCarlo, of: str = "") -> list[Block]:
    """One table for each kind of parameter; `of` is what their titles begin with."""
    # A fit has no filter.
    is_fit = [bool(fitted_output(method)) for method in result.methods]
    without = f" without the bias of filter and noise{', where there is one' * any(is_fit)}"
    titles = {**_TITLES, PARAMETER: _TITLES[PARAMETER] + without * (not all(is_fit))}
    return [
        _estimands(result, of_kind, f"{of}: {title[0].lower()}{title[1:]}" if of else title)
        for kind, title in titles.items()
        if (of_kind := [each for each in result.figures if each.kind == kind])
    ]


def _estimands(
    result: SavedMonteCarlo, listed: Sequence[EstimandFigures], title: str
) -> TableBlock:
    chosen = result.chosen
    others = [
        of
        for of in (*COVARIANCES, MODEL_ERROR)
        if any(
            of in each.coverage and of != interval_covariance(each.method, chosen)
            for each in listed
        )
    ]
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            *(method_title(each.method), each.name, each.unit, _number(each.truth, 6)),
            *(mean_cell(each.bias), mean_cell(each.scatter)),
            _number(each.deviations.get(stated, math.nan), 2),
            *share_texts(each.coverage.get(stated)),
            *("" if of == stated else share_texts(each.coverage.get(of))[0] for of in others),
        )
        for each in listed
        for stated in [interval_covariance(each.method, chosen)]
    )
    return TableBlock(
        columns=(
            *text_columns(["method", "", "unit"]),
            TableColumn("truth"),
            TableColumn("bias", parts=("error",)),
            TableColumn("scatter", parts=("error",)),
            TableColumn("stated"),
            TableColumn("holds", "%", group="holds"),
            TableColumn("95 % interval", "%", group="holds"),
            *(TableColumn(_label(of), "%") for of in others),
        ),
        rows=rows,
        labels=2,
        title=title,
    )


def _label(of: str) -> str:
    return _LABELS[of] if of in _LABELS else COVARIANCES[of].label


def _stated_labels(result: SavedMonteCarlo) -> str:
    """What the printed intervals are of, by all methods."""
    return " and ".join(
        dict.fromkeys(
            _label(interval_covariance(method, result.chosen)) for method in result.methods
        )
    )


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else figure_text(value, digits)


def mean_cell(mean: Mean) -> QuantityCell:
    """A figure with its Monte-Carlo error, to the digits that the error tells."""
    if math.isnan(mean.value):
        return QuantityCell("-", "-")
    if not _PLAIN[0] <= mean.error < _PLAIN[1]:
        return QuantityCell(f"{mean.value:.3g}", _number(mean.error, 2))
    places = decimals(mean.error)
    return QuantityCell(f"{mean.value:.{places}f}", f"{mean.error:.{places}f}")


def share_texts(share: Share | None) -> tuple[str, str]:
    """A share in percent, and Wilson's interval to two digits of its width; dashes of none."""
    if share is None or not share.of:
        return "-", "-"
    low, value, high = (100 * each for each in (share.interval[0], share.value, share.interval[1]))
    places = decimals(high - low)
    return f"{value:.{places}f}", f"{low:.{places}f} to {high:.{places}f}"


def study_checks(result: SavedMonteCarlo) -> TableBlock:
    """How often each check fails; of those that do not pass in every run, and were evaluated."""
    beyond = [each for each in result.check_figures if each.passes.of > 0 and not _is_silent(each)]
    return TableBlock(
        columns=(
            *text_columns(["check"]),
            *(
                TableColumn(head, "%", group=group)
                for group in ("fails", "notes")
                for head in (group, "95 % interval")
            ),
            TableColumn("not evaluated", "%"),
        ),
        rows=(
            *(
                (
                    check.name,
                    *share_texts(check.fails),
                    *share_texts(check.notes),
                    share_texts(check.missing)[0],
                )
                for check in beyond
            ),
            ("any of them", *share_texts(result.objected), "", "", ""),
        ),
        title=f"Checks of {result.judged} verdicts",
    )


def _is_silent(check: CheckFigures) -> bool:
    """Whether it was evaluated in every run and passed."""
    return check.passes.count == check.missing.of


def legend(result: SavedMonteCarlo) -> Paragraph:
    """What the columns are."""
    silent = ", ".join(each.name for each in result.check_figures if _is_silent(each))
    unseen = ", ".join(each.name for each in result.check_figures if not each.passes.of)
    return paragraph(
        "bias, scatter: mean error and standard deviation over the runs, with their standard "
        f"errors. stated: deviation, {_stated_labels(result)}. holds: share of its intervals "
        "that hold the truth, with Wilson's 95 % interval; after it that of other deviations.",
        *([f"Passed in every run: {silent}."] if silent else []),
        *([f"Evaluated in no run, so that nothing is known of them: {unseen}."] if unseen else []),
    )


def findings(result: SavedMonteCarlo) -> Paragraph:
    """What is beyond the Monte-Carlo error, and what came to nothing."""
    share, interval = share_texts(result.objected)
    objected = (
        f"A check fails in {share} % ({interval} %) of {result.judged} verdicts on "
        f"{'the right' if result.twins.right else 'a wrong'} model."
    )
    return paragraph(
        *(f"{check.meaning}." for check in result.checks if check.status != "not evaluated"),
        *([objected] if result.judged else []),
    )
