"""A Monte-Carlo study as tables: bias, scatter, coverage of intervals, failure rates of checks."""

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

_PLAIN = (1e-6, 1e6)  # Monte-Carlo errors between which numbers have no power of ten

#: Names of covariances that have no label of their own.
_LABELS = {MODEL_ERROR: "model error", COLOURED: "autoregressive errors"}
#: Titles of the tables of parameters, by kind of parameter.
_TITLES = {
    PARAMETER: "Estimates",
    DIRECT: "Parameters of the direct model",
    PHYSICAL: "Declared parameters that can be calculated",
}


def study_document(result: SavedMonteCarlo) -> Document:
    """Return a study as a document: settings, estimates, rates of checks, legend and findings."""
    return (
        Heading(facts=heading_facts(result)),
        *estimand_tables(result),
        *([study_checks(result)] if result.judged else []),
        legend(result),
        findings(result),
    )


def heading_facts(result: SavedMonteCarlo) -> dict[str, str]:
    """Return the settings of the runs as texts by name, for a heading."""
    twins, noise = result.twins, result.noise
    start = ", start at a random place within an encoder step" if noise.anywhere else ""
    done = f"{len(result)}" if len(result) == result.runs else f"{len(result)} of {result.runs}"
    return {
        "axis": result.name,
        "twins": f"{done} twins of {twins.axis}, seed {result.seed}",
        "noise": sentence(noise_sources(noise, twins.unit, twins.drive_unit)) + start,
        "model": "the same as simulated" if twins.right else "different from the simulated model",
        "methods": ", ".join(map(method_title, result.methods)),
        "intervals": f"{100 * INTERVAL_LEVEL.value:g} %, {_printed_labels(result)}",
    }


def estimand_tables(result: SavedMonteCarlo, of: str = "") -> list[Block]:
    """Return one table for each kind of parameter that the study has.

    Parameters
    ----------
    result : SavedMonteCarlo
    of : str
        Beginning of the titles; empty for none.
    """
    # A fit has no filter, so its values are not corrected.
    are_fits = [bool(fitted_output(method)) for method in result.methods]
    titles = dict(_TITLES)
    if not all(are_fits):
        titles[PARAMETER] += ", corrected for the bias of filter and noise"
        if any(are_fits):
            titles[PARAMETER] += " (not for fits)"
    tables: list[Block] = []
    for kind, title in titles.items():
        of_kind = [each for each in result.figures if each.kind == kind]
        if of_kind:
            full_title = f"{of}: {title[0].lower()}{title[1:]}" if of else title
            tables.append(_estimands(result, of_kind, full_title))
    return tables


def _estimands(
    result: SavedMonteCarlo, listed: Sequence[EstimandFigures], title: str
) -> TableBlock:
    """Return the table of one kind of parameter: bias, scatter, standard error, coverage.

    The last columns have the coverage with other covariances than that of the printed intervals.
    """
    chosen = result.chosen
    others = [
        covariance
        for covariance in (*COVARIANCES, MODEL_ERROR)
        if any(
            covariance in each.coverage and covariance != interval_covariance(each.method, chosen)
            for each in listed
        )
    ]
    rows = tuple(_estimand_row(each, chosen, others) for each in listed)
    return TableBlock(
        columns=(
            *text_columns(["method", "", "unit"]),
            TableColumn("truth"),
            TableColumn("bias", parts=("MC error",)),
            TableColumn("scatter", parts=("MC error",)),
            TableColumn("sd"),
            TableColumn("coverage", "%", group="coverage"),
            TableColumn("95 % interval", "%", group="coverage"),
            *(TableColumn(_label(covariance), "%") for covariance in others),
        ),
        rows=rows,
        labels=2,
        title=title,
    )


def _estimand_row(each: EstimandFigures, chosen: str, others: Sequence[str]) -> tuple[Cell, ...]:
    """Return the table row of one parameter by one method.

    Parameters
    ----------
    each : EstimandFigures
    chosen : str
        Chosen covariance of the study.
    others : sequence of str
        Covariances of the last columns.
    """
    printed = interval_covariance(each.method, chosen)
    return (
        *(method_title(each.method), each.name, each.unit, _number(each.truth, 6)),
        *(mean_cell(each.bias), mean_cell(each.scatter)),
        _number(each.deviations.get(printed, math.nan), 2),
        *share_texts(each.coverage.get(printed)),
        *(
            "" if covariance == printed else share_texts(each.coverage.get(covariance))[0]
            for covariance in others
        ),
    )


def _label(covariance: str) -> str:
    """Return the name of a covariance in tables."""
    return _LABELS[covariance] if covariance in _LABELS else COVARIANCES[covariance].label


def _printed_labels(result: SavedMonteCarlo) -> str:
    """Return the names of the covariances that the printed intervals of all methods use."""
    return " and ".join(
        dict.fromkeys(
            _label(interval_covariance(method, result.chosen)) for method in result.methods
        )
    )


def _number(value: float, digits: int) -> str:
    """Return a number as text with `digits` digits; a dash for NaN."""
    return "-" if math.isnan(value) else figure_text(value, digits)


def mean_cell(mean: Mean) -> QuantityCell:
    """Return a mean with its Monte-Carlo standard error as a cell.

    Both are rounded to two digits of the standard error; dashes for NaN.
    """
    if math.isnan(mean.value):
        return QuantityCell("-", "-")
    if not _PLAIN[0] <= mean.error < _PLAIN[1]:
        return QuantityCell(f"{mean.value:.3g}", _number(mean.error, 2))
    places = decimals(mean.error)
    return QuantityCell(f"{mean.value:.{places}f}", f"{mean.error:.{places}f}")


def share_texts(share: Share | None) -> tuple[str, str]:
    """Return a share in percent and its Wilson interval as texts; dashes for None or no runs."""
    if share is None or not share.of:
        return "-", "-"
    low, value, high = (100 * each for each in (share.interval[0], share.value, share.interval[1]))
    places = decimals(high - low)
    return f"{value:.{places}f}", f"{low:.{places}f} to {high:.{places}f}"


def study_checks(result: SavedMonteCarlo) -> TableBlock:
    """Return a table of how often each check fails or has a note.

    Checks that pass in every run, or are never evaluated, have no row.
    """
    listed = [
        each for each in result.check_figures if each.passes.of > 0 and not _always_passes(each)
    ]
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
                for check in listed
            ),
            ("any check", *share_texts(result.objected), "", "", ""),
        ),
        title=f"Checks in {result.judged} verdicts: share of runs in which a check fails or has a "
        "note",
    )


def _always_passes(check: CheckFigures) -> bool:
    """Return True if the check was evaluated and passed in every run with a verdict."""
    # `passes` is a share of the runs with this check; `missing` is a share of all runs.
    number_of_runs = check.missing.of
    return check.passes.count == number_of_runs


def legend(result: SavedMonteCarlo) -> Paragraph:
    """Return the explanation of the columns, and the checks without a row."""
    passed = ", ".join(each.name for each in result.check_figures if _always_passes(each))
    not_evaluated = ", ".join(each.name for each in result.check_figures if not each.passes.of)
    return paragraph(
        "bias: mean error of the values in this table over the runs. scatter: their standard "
        "deviation. MC error: Monte-Carlo standard error of the number before it. sd: root mean "
        f"square over the runs of the reported standard error ({_printed_labels(result)}).",
        "coverage: share of the 95 % intervals that contain the true value, with Wilson's 95 % "
        "interval for this share. The last columns show the coverage of intervals with other "
        "standard errors (robust: consistent for heteroscedasticity only).",
        *([f"Passed in every run: {passed}."] if passed else []),
        *([f"Not evaluated in any run: {not_evaluated}."] if not_evaluated else []),
    )


def findings(result: SavedMonteCarlo) -> Paragraph:
    """Return sentences on the study's own checks, and the share of verdicts with a failed check."""
    share, interval = share_texts(result.objected)
    failing = (
        f"At least one check fails in {share} % ({interval} %) of {result.judged} verdicts on "
        f"{'the correct' if result.twins.right else 'an incorrect'} model."
    )
    return paragraph(
        *(f"{check.meaning}." for check in result.checks if check.status != "not evaluated"),
        *([failing] if result.judged else []),
    )
