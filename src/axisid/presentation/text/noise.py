"""What noise does to least squares, in a table's rows, in notes and in full."""

from collections.abc import Iterable, Mapping, Sequence

from axisid.estimation.diagnostics import Diagnosis
from axisid.estimation.estimates import Value
from axisid.estimation.noise import NoiseBias
from axisid.presentation.blocks import Cell, Document, Paragraph, Table, paragraph, text_columns
from axisid.support.missing import Missing

from .estimate import places

_MOVED = "moved by noise"


def noise_row(
    values: Sequence[Value], biases: Sequence[NoiseBias | None]
) -> list[tuple[Cell, ...]]:
    """By how much noise has moved a value of least squares, where that is noticeable."""
    if not any(bias is not None and bias.moved for bias in biases):
        return []
    cells = (
        f"{bias.difference:+.{places(value)}f}" if bias is not None and bias.moved else "-"
        for value, bias in zip(values, biases, strict=True)
    )
    return [(f"  {_MOVED}", "", *cells)]


def noise_notes(diagnosis: Diagnosis) -> list[str]:
    """What those rows are, if there are any."""
    every = (bias for of_one in diagnosis.noise_biases.values() for bias in of_one.values())
    if not any(bias.moved for bias in every):
        return []
    return [
        f"{_MOVED}: least squares less instruments of the same form, where that is more than "
        "chance (HAC Hausman test, 1 %) and more than half a deviation. The 95 % interval of that "
        "value holds the truth less often for it; believe the instruments."
    ]


def noise_details(diagnosis: Diagnosis, units: Mapping[str, str]) -> Document:
    """Every difference with its test, and the two forms of least squares against each other."""
    return _differences(diagnosis.noise_biases, units), _forms(diagnosis)


def _differences(
    biases: Mapping[str, Mapping[str, NoiseBias]], units: Mapping[str, str]
) -> Table | Paragraph:
    title = "Least squares less instruments, Hausman, HAC"
    if not biases:
        return paragraph("not tested: no form has both, or instruments are weak", title=title)
    rows = (row for method, of_one in biases.items() for row in _rows(method, of_one, units))
    heads = ("", "unit", "difference", "sd of it", "in sd of LS", "p", "p of all", "interval")
    return Table(columns=text_columns(heads), rows=tuple(rows), labels=2, title=title)


def _rows(
    method: str, biases: Mapping[str, NoiseBias], units: Mapping[str, str]
) -> Iterable[tuple[str, ...]]:
    for name, bias in biases.items():
        yield (
            f"{method.upper()} {name}",
            units[name],
            f"{bias.difference:+.3g}",
            f"{bias.deviation:.2g}",
            f"{bias.shift:.2g}",
            f"{bias.p_value:.2g}",
            f"{bias.joint_p_value:.2g}",
            "misses" if bias.misses else "moved" if bias.moved else "-",
        )


def _forms(diagnosis: Diagnosis) -> Paragraph:
    title = "Inverse against direct least squares"
    found = diagnosis.attenuation
    if isinstance(found, Missing):
        return paragraph(f"not compared: {found}", title=title)
    return paragraph(
        f"{found.parameter} = {found.inverse:.6g} by idm-ls, {found.direct:.6g} by ddm-ls; "
        f"r^2 = {found.r_squared:.7f} of force and acceleration, the other columns given, is their "
        f"quotient to {found.identity_error:.1g}; they are {found.shift:.2g} deviations apart",
        title=title,
    )
