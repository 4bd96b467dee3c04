"""The page of an axis: its declaration and derived models, as text, LaTeX or Markdown."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby

from axisid.modeling.declaration import Axis, ControlLaw, Experiment, equation_of_motion, known_text
from axisid.modeling.derivation import (
    AxisModel,
    Section,
    derived_sections,
    describe_determined,
    describe_undetermined,
)
from axisid.modeling.quantities import FORCE, Coordinate, Formula, Parameter, rounded, written

from .document import Document, Listing, paragraph
from .latex import aligned_latex, escaped_latex
from .plain import plain_text

FORMATS = ("text", "latex", "markdown")

_MARKDOWN = str.maketrans({c: f"\\{c}" for c in "\\`*_{}[]<>#|$"})


def axis_page(model: AxisModel, form: str = "text") -> str:
    """Return the page of an axis as text; `form` is one of `FORMATS`."""
    if form == "text":
        return plain_text(axis_document(model))
    write = {"latex": _latex, "markdown": _markdown}[form]
    return write(_title(model), _sections(model), model.axis.coordinate)


def axis_document(model: AxisModel) -> Document:
    """Return the page of an axis as a document: its title, then one listing per section."""
    return (
        paragraph(_title(model)),
        *(
            Listing(title=section.title, lines=tuple(_lines(section, model.axis.coordinate)))
            for section in _sections(model)
        ),
    )


def _title(model: AxisModel) -> str:
    """Return the title of the page: name and title of the axis, or the name alone."""
    return f"{model.axis.name}: {model.axis.title}".removesuffix(": ")


def _sections(model: AxisModel) -> list[Section]:
    """Return all sections of the page: declaration, derived models, drive, law and experiment."""
    declared = model.base.declared
    combined = {p.symbol: value for p, value in model.base.combined}
    inertia = Formula(name="inertia", value=rounded(model.inertia.xreplace(combined)))
    return [
        *_motion(declared, inertia),
        *_signals(declared),
        *derived_sections(model),
        *_physical(model),
        *_drive_law_and_record(declared),
    ]


def motion_sections(axis: Axis) -> list[Section]:
    """Return the sections of the equation of motion, its parameters, the drive and the law."""
    drive, law, *_ = _drive_law_and_record(axis)
    return [*_motion(axis), drive, law]


def _motion(axis: Axis, *more: Formula) -> list[Section]:
    """Return the sections of the equation of motion and of its parameters.

    `more` are further formulas of the first section.
    """
    q = axis.coordinate
    equation = Section(
        title="Equation of motion",
        lines=(equation_of_motion(axis), *more),
        note=f"position {q.symbol} [{q.unit}], velocity {q.velocity}, acceleration "
        f"{q.acceleration}; {FORCE} is the drive's force on the load side",
    )
    facts = [(p.name, p.unit, ", ".join(filter(None, _facts(p)))) for p in axis.parameters]
    return [equation, Section(title="Parameters", lines=_listed(facts))]


def _facts(p: Parameter) -> tuple[str, ...]:
    """Return nominal value, bounds, known value and description of a parameter as texts.

    A text is empty if the parameter has no such property.
    """
    return (
        f"nominal {p.nominal:g}",
        f"at least {p.lower:g}" if p.lower > -math.inf else "",
        f"at most {p.upper:g}" if p.upper < math.inf else "",
        "" if p.known is None else f"known: {known_text(p.known, p.known_sd)}",
        p.description,
    )


def _listed(named: Sequence[tuple[str, str, str]]) -> tuple[str, ...]:
    """Return lines of name, unit and description, aligned in columns."""
    name_width = max(len(name) for name, _, _ in named)
    unit_width = max(len(unit) for _, unit, _ in named) + 2  # with brackets
    return tuple(
        f"{name:<{name_width}}  {f'[{unit}]':<{unit_width}}  {description}"
        for name, unit, description in named
    )


def _physical(model: AxisModel) -> list[Section]:
    """Return a section on the declared parameters that a record determines, in a list.

    The list is empty if all declared parameters are estimated directly.
    """
    base = model.base
    if not (base.changed or base.known):
        return []
    determined = describe_determined(base)
    lines = (*((determined,) if determined else ()), *describe_undetermined(base))
    return [Section(title="Physical parameters", lines=lines)]


def _signals(axis: Axis) -> list[Section]:
    """Return a section on the recorded signals, in a list; empty if there are none."""
    if not axis.signals:
        return []
    named = []
    for signal in axis.signals:
        description = f"{signal.between} between samples"
        if signal.description:
            description += f", {signal.description}"
        named.append((signal.name, signal.unit, description))
    return [Section(title="Recorded signals", lines=_listed(named))]


def _drive_law_and_record(axis: Axis) -> list[Section]:
    """Return the sections of drive, control law, columns of a record, and experiment if any."""
    drive, unit = axis.drive, axis.drive.unit
    facts = (
        f"{FORCE} = {drive.force_text(axis.coordinate, digits=10)}",
        f"the control is clipped at {drive.limit:g} {unit}" if drive.limit < math.inf else "",
        f"relative standard error of the gain: {100 * drive.relative_sd:g} %"
        if drive.relative_sd
        else "",
        drive.timing_text,
        drive.remark,
    )
    columns = tuple(f"{role} = {name}" for role, name in axis.columns.items())
    return [
        Section(title="Drive", lines=tuple(filter(None, facts))),
        _law(axis.control, unit),
        Section(title="Columns of a record", lines=columns or ("columns have the role as name",)),
        *([] if axis.experiment is None else [_experiment(axis, axis.experiment)]),
    ]


def _law(law: ControlLaw | None, unit: str) -> Section:
    """Return the section of the control law: output, memory, gains and timing.

    `unit` is the unit of the control.
    """
    if law is None:
        return Section(
            title="Control law", lines=("no control law: only least squares, no instruments",)
        )
    lines: tuple[Formula | str, ...] = (
        Formula(name="control", value=law.output, unit=unit),
        *(
            Formula(name=f"{memory.name} at the {when} sample", value=value)
            for memory in law.memory
            for when, value in (("next", memory.following), ("first", memory.start))
        ),
        *(f"{name} = {value:.10g}" for name, value in law.gains.items()),
    )
    note = f"{law.name}; evaluated every {law.period:g} s, output held in between"
    if law.continuous:
        note = f"{law.name}; evaluated continuously"
    if law.delay:
        note += f"; applied with a delay of {law.delay} samples"
    if law.reference_between:
        note += f"; with its own clock, reference {law.reference_between} between samples"
    if law.memory:
        note += f"; values that the law stores: {', '.join(m.name for m in law.memory)}"
    return Section(title="Control law", lines=lines, note=note)


def _experiment(axis: Axis, experiment: Experiment) -> Section:
    """Return the section of the experiment of the axis's twin: motion, noise and true values."""
    seconds = sum(move.duration for move in experiment.moves)
    truth = [f"{p.name} = {experiment.truth.get(p.name, p.nominal):g}" for p in axis.parameters]
    unit = axis.coordinate.unit
    noise = f"{experiment.position_noise:g} {unit}"
    if experiment.resolution:
        noise += f", encoder step {experiment.resolution:g} {unit}"
    return Section(
        title="Experiment of the twin",
        lines=(
            f"{len(experiment.moves)} moves in {seconds:.4g} s; position noise {noise}, seed "
            f"{experiment.seed}",
            f"true values {', '.join(truth)}",
            *(Formula(name=name, value=x) for name, x in experiment.signals.items()),
        ),
    )


def _lines(section: Section, coordinate: Coordinate) -> Iterator[str]:
    """Yield the note of a section, then its facts and formulas.

    If a formula has a column of the regressor, names and units of all formulas are aligned.
    """
    if section.note:
        yield f"({section.note})"
    formulas = [line for line in section.lines if isinstance(line, Formula)]
    head_width = unit_width = 0
    if any(formula.column is not None for formula in formulas):
        head_width = max(len(formula.head(coordinate)) for formula in formulas)
        unit_width = max(len(formula.unit) for formula in formulas) + 2  # with brackets
    for line in section.lines:
        if isinstance(line, str):
            yield line
            continue
        label = f"{line.head(coordinate):<{head_width}}"
        if line.unit or unit_width:
            unit = f"[{line.unit}]" if line.unit else ""
            label += f"  {unit:<{unit_width}}"
        yield label if line.column is None else f"{label}  : {written(line.column, coordinate)}"


def _latex(title: str, sections: Iterable[Section], coordinate: Coordinate) -> str:
    """Return a page as a LaTeX document."""
    body = _body(
        sections,
        lambda head: ("", rf"\subsection*{{{escaped_latex(head)}}}"),
        lambda note: (escaped_latex(note),),
        lambda sentences: (" \\\\\n".join(map(escaped_latex, sentences)),),
        lambda lines: (r"\begin{align*}", aligned_latex(lines, coordinate), r"\end{align*}"),
    )
    begin = (
        r"\documentclass{article}",
        r"\usepackage{amsmath}",
        r"\begin{document}",
        rf"\section*{{{escaped_latex(title)}}}",
    )
    return "\n".join([*begin, *body, "", r"\end{document}"]) + "\n"


def _markdown(title: str, sections: Iterable[Section], coordinate: Coordinate) -> str:
    """Return a page as Markdown."""
    body = _body(
        sections,
        lambda head: ("", f"## {head.translate(_MARKDOWN)}", ""),
        lambda note: (note.translate(_MARKDOWN), ""),
        lambda sentences: [f"- {' '.join(s.split()).translate(_MARKDOWN)}" for s in sentences],
        lambda lines: (
            "$$",
            r"\begin{aligned}",
            aligned_latex(lines, coordinate),
            r"\end{aligned}",
            "$$",
        ),
    )
    return "\n".join([f"# {title.translate(_MARKDOWN)}", *body]) + "\n"


def _body(
    sections: Iterable[Section],
    head: Callable[[str], Iterable[str]],
    note: Callable[[str], Iterable[str]],
    listed: Callable[[list[str]], Iterable[str]],
    aligned: Callable[[list[Formula]], Iterable[str]],
) -> Iterator[str]:
    """Yield the lines of sections in one format.

    Parameters
    ----------
    sections : iterable of Section
    head, note : callable
        Returns the lines of a title, and of a note.
    listed, aligned : callable
        Returns the lines of consecutive sentences, and of consecutive formulas.
    """
    for section in sections:
        yield from head(section.title)
        if section.note:
            yield from note(f"{section.note[:1].upper()}{section.note[1:]}.")
        for is_text, lines in groupby(section.lines, lambda line: isinstance(line, str)):
            group = [*lines]
            if is_text:
                yield from listed([line for line in group if isinstance(line, str)])
            else:
                yield from aligned([line for line in group if isinstance(line, Formula)])
