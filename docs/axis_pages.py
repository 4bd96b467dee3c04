"""Write a page for every library axis, `docs/axes/NAME.md`, from its declaration.

python docs/axis_pages.py
"""

import re
import sys
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from axisid import derive, load_axis
from axisid.modeling import LIBRARY, AxisModel
from axisid.modeling.declaration import Axis
from axisid.modeling.quantities import named_constants
from axisid.modeling.wording import describe_combinations
from axisid.presentation.formulas.latex import equation_latex
from axisid.support.missing import Missing
from benchmarks.library import prefilter_of

FOLDER = ROOT / "docs" / "axes"


def page(name: str) -> str:
    """The page of a library axis."""
    axis = load_axis(name)
    about = import_module(f"axisid.modeling.library.{name}").__doc__ or ""
    model = derive(axis)
    parts = [
        f"# {name}: {axis.title}",
        _linked(about.strip()),
        "## Equation of motion",
        _equation(axis),
        "## Parameters",
        _parameters(axis),
        "## What can be identified",
        _identifiable(model),
        "## The twin",
        _twin(axis),
    ]
    return "\n\n".join(parts) + "\n"


def _linked(text: str) -> str:
    return re.sub(r"\[(\w+\d{4})\]_", r"[\1](../references.bib)", text).replace("``", "`")


def _equation(axis: Axis) -> str:
    constants = named_constants(axis.force + axis.drive.profile)
    listed = "".join(f", {c.name} = {c.value:g} {c.unit}" for c in constants)
    drive = axis.drive
    facts = (
        f"`tau = {drive.gain:.6g} * control` in {axis.coordinate.force_unit}, the control in "
        f"{drive.unit}, at most {drive.limit:g}{listed}."
    )
    acts = drive.timing_text
    facts += f" {acts[0].upper()}{acts[1:]}." if acts else ""
    return f"{equation_latex(axis)}\n\n{facts}"


def _parameters(axis: Axis) -> str:
    truth = axis.experiment.truth if axis.experiment else {}
    rows = [
        f"| {p.name} | {p.unit} | {p.description} | {p.nominal:g} | {truth[p.name]:g} |"
        for p in axis.parameters
    ]
    return "\n".join(["| | unit | | nominal | twin |", "|---|---|---|---|---|", *rows])


def _identifiable(model: AxisModel) -> str:
    lines = [
        f"Only {describe_combinations(unidentifiable)}." for unidentifiable in model.unidentifiable
    ]
    lines = lines or ["Every parameter has an effect of its own."]
    if isinstance(model.ddm, Missing):
        lines.append("There is no direct regressor: IDM-LS, IDM-IV and DIDIM identify it.")
    else:
        lines.append("Every method identifies it: IDM-LS, DDM-LS, IDM-IV, DDM-IV and DIDIM.")
    lines += [f"Not checked in its unit: {term}." for term in model.axis.unchecked_terms]
    return " ".join(lines)


def _twin(axis: Axis) -> str:
    if axis.control is None or axis.experiment is None:
        return "It has none."
    settings, options = prefilter_of(axis.name), ""
    if settings is not None:
        options = f" --cutoff {settings.cutoff:g} --decimate {settings.decimate}"
    law, unit, counts = axis.control, axis.coordinate.unit, axis.experiment.resolution
    timing = f" {axis.drive.timing_text.capitalize()}." if axis.drive.timing_text else ""
    return (
        f"Control law: {law.name}, every {1e3 * law.period:g} ms.{timing} Encoder noise: "
        f"{axis.experiment.position_noise:g} {unit}"
        f"{f', whole counts of {counts:g} {unit}' if counts else ''}.\n\n"
        f"```console\n$ axisid identify {axis.name}{options}\n```"
    )


def main() -> None:
    """Write the pages, and leave those alone that are current."""
    FOLDER.mkdir(exist_ok=True)
    for name in LIBRARY:
        file, text = FOLDER / f"{name}.md", page(name)
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
            print(f"wrote {file.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
