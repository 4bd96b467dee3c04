"""What the gallery says of a library axis, from its declaration."""

import re
from importlib import import_module

from axisid import derive, load_axis
from axisid.modeling import AxisModel
from axisid.modeling.declaration import Axis, equation_of_motion
from axisid.modeling.derivation import describe_loss
from axisid.modeling.quantities import ConstantSymbol
from axisid.presentation.documents.latex import aligned_latex
from axisid.support.missing import Missing
from benchmarks.library import prefilter_of


def text_of(name: str) -> str:
    """Markdown of a library axis: what it is, its equation, drive, parameters and twin."""
    axis = load_axis(name)
    about = import_module(f"axisid.modeling.library.{name}").__doc__ or ""
    equation = aligned_latex([equation_of_motion(axis)], axis.coordinate)
    parts = [
        _linked(about.strip()),
        f"$$\n\\begin{{aligned}}\n{equation}\n\\end{{aligned}}\n$$",
        _drive(axis),
        _parameters(axis),
        _exceptions(derive(axis)),
        _twin(axis),
    ]
    return "\n\n".join(part for part in parts if part)


def _linked(text: str) -> str:
    return re.sub(r"\[(\w+\d{4})\]_", r"[\1](references.bib)", text).replace("``", "`")


def _drive(axis: Axis) -> str:
    found = (axis.force + axis.drive.profile).atoms(ConstantSymbol)
    named = sorted((c for c in found if c.name.isidentifier()), key=str)
    listed = "".join(f", {c.name} = {c.value:g} {c.unit}" for c in named)
    drive = axis.drive
    facts = (
        f"`tau = {drive.gain:.6g} * control` in {axis.coordinate.force_unit}, the control in "
        f"{drive.unit}, at most {drive.limit:g}{listed}."
    )
    acts = drive.timing_text
    return facts + (f" {acts[0].upper()}{acts[1:]}." if acts else "")


def _parameters(axis: Axis) -> str:
    truth = axis.experiment.truth if axis.experiment else {}
    rows = [
        f"| {p.name} | {p.unit} | {p.description} | {p.nominal:g} | {truth[p.name]:g} |"
        for p in axis.parameters
    ]
    return "\n".join(["| | unit | | nominal | twin |", "|---|---|---|---|---|", *rows])


def _exceptions(model: AxisModel) -> str:
    """What no motion tells, methods that cannot run, terms whose unit is not checked."""
    lines = [f"{describe_loss(lost).capitalize()}." for lost in model.unidentifiable]
    if isinstance(model.ddm, Missing):
        lines.append("No direct regressor, so neither DDM-LS nor DDM-IV.")
    lines += [f"Not checked in its unit: {term}." for term in model.axis.unchecked_terms]
    return " ".join(lines)


def _twin(axis: Axis) -> str:
    if axis.control is None or axis.experiment is None:
        return "No twin."
    settings, options = prefilter_of(axis.name), ""
    if settings is not None:
        options = f" --cutoff {settings.cutoff:g} --decimate {settings.decimate}"
    law, unit, counts = axis.control, axis.coordinate.unit, axis.experiment.resolution
    return (
        f"Twin: {law.name}; period {1e3 * law.period:g} ms; encoder noise "
        f"{axis.experiment.position_noise:g} {unit}"
        f"{f', whole counts of {counts:g} {unit}' if counts else ''}.\n\n"
        f"```console\n$ axisid identify {axis.name}{options}\n```"
    )
