"""Sentences of terms that a model lacks, and of parameters that change or are given wrongly."""

from collections.abc import Mapping
from dataclasses import dataclass

from axisid.estimation.diagnostics import MissingTerms, MovedParameter
from axisid.estimation.misspecification import (
    CandidateTerm,
    ChangedParameter,
    MissingTerm,
    ShareOfForce,
)
from axisid.support.settings import setting

from .dispatch import sentence
from .words import capitalised, one_after_another


@dataclass(frozen=True, slots=True, kw_only=True)
class _Words:
    """Words of a built-in term, with its numbers, units and the coordinate's name to fill in.

    Attributes
    ----------
    name : str
        Name of the force.
    advice : str
        Instruction, which begins with a verb.
    statement : str
        States that the term is missing; if empty, the statement is formed from the name.
    size : str
        Describes the size of the term, which is filled in for ``{size}``.
    """

    name: str
    advice: str
    statement: str = ""
    size: str = "{size}"

    @property
    def said(self) -> str:
        """Return the statement."""
        return self.statement or f"{self.name} is missing"


#: Words by kind of the built-in terms.
_WORDS: Mapping[str, _Words] = {
    "constant": _Words(name="a constant force", advice="declare offset(F0)"),
    "coulomb": _Words(name="Coulomb friction", advice="declare coulomb(Fc, {q})"),
    "viscous": _Words(name="viscous friction", advice="declare viscous(Fv, {q})"),
    "inertia": _Words(
        name="a force proportional to the acceleration", advice="declare another inertia"
    ),
    "direction": _Words(
        name="viscous friction that differs between directions",
        statement="viscous friction differs between directions",
        size="forward minus backward = {size}",
        advice="try asymmetric_viscous(Fvp, Fvm, {q}) instead of viscous",
    ),
    "quadratic": _Words(
        name="friction proportional to the square of the speed",
        advice="declare quadratic(Fq, {q}), or a Stribeck peak (stribeck) if friction differs at "
        "low speed",
    ),
    "stribeck": _Words(
        name="friction that is higher or lower at speeds up to about {at:.1g} {unit}/s",
        statement="friction is {side} at speeds up to about {at:.1g} {unit}/s",
        advice="declare stribeck(Fs, {q}, velocity={at:.1g}, exponent=1) in addition to coulomb",
    ),
    "slope": _Words(name="a force proportional to the position", advice="declare spring(k, {q})"),
    "bend": _Words(
        name="a force proportional to the square of the position",
        advice="declare offset(kq*{q}**2)",
    ),
    "turn": _Words(
        name="a torque that is periodic in one turn",
        advice="declare gravity_moment(a, b, {q})",
    ),
    "place": _Words(
        name="a force that is periodic in the position (every {at:.3g} {unit})",
        advice="declare cogging(a, b, {q}, period={at:.3g})",
    ),
    "friction slope": _Words(
        name="friction that depends on the position (linearly)",
        statement="friction depends on the position (linearly)",
        advice="declare coulomb(Fq*{q}, {q}) in addition to the declared friction",
    ),
    "friction bend": _Words(
        name="friction that depends on the position (by its square)",
        statement="friction depends on the position (by its square)",
        advice="declare coulomb(Fq*{q}**2, {q}) in addition to the declared friction",
    ),
    "friction place": _Words(
        name="friction that depends on the position (every {at:.3g} {unit})",
        statement="friction depends on the position (every {at:.3g} {unit})",
        advice="declare periodic_coulomb(a, b, {q}, period={at:.3g})",
    ),
    "resonance": _Words(
        name="a resonance with an antiresonance near {at:.2g} Hz",
        statement="the axis has a resonance with an antiresonance near {at:.2g} Hz, and a rigid "
        "model is valid up to about {rigid:.2g} Hz",
        advice="lower the cut-off of identify to that frequency ({cutoff}), or move more slowly",
    ),
    "delay": _Words(
        name="a lag, a delay or a rate limit of the drive",
        statement="the drive has another lag or delay than declared, or a rate limit that noise "
        "reaches",
        advice="declare it, or move the column that is late",
    ),
    "loss": _Words(
        name="a load-dependent loss",
        statement="the load causes a loss: the drive gives less force where it drives, and more "
        "where it brakes",
        advice="compare its share of the force with the accuracy that you need, as no element "
        "describes it",
    ),
    "presliding": _Words(
        name="friction that differs just after a velocity reversal (pre-sliding)",
        statement="friction is higher or lower just after a velocity reversal (pre-sliding)",
        advice="declare a bristle model (dahl or lugre), or leave out more of the reversals",
    ),
    "backlash": _Words(
        name="a force that is late at its change of sign (backlash)",
        statement="the force is late where it changes its sign (backlash, play)",
        advice="remove the play, or identify motions in which the force keeps its sign",
    ),
    "dead band": _Words(
        name="a dead band of the drive",
        statement="the drive gives less force than its control commands, in both directions",
        advice="declare its dead band{dead_band}",
    ),
    "saturation": _Words(
        name="a limit of the drive at about {at:.2g} {force}",
        statement="the drive gives no more than about {at:.2g} {force}, whatever is commanded",
        advice="declare its limit{limit_set}, or command less",
    ),
}
#: Of a delay that is negative.
_EARLY = _Words(
    name="a force that acts before the recorded control",
    statement="a force acts before the recorded control: the control lacks a feed-forward, a delay "
    "or lag is declared too long, or a column is late",
    advice="record the control with the feed-forward, correct the declared drive, or move the "
    "column",
)


@sentence.register
def missing_terms(finding: MissingTerms) -> str:
    """Return what the model lacks, the largest part of the force first."""
    if not finding.found:
        return "the residual has none of the terms that were tested"
    texts = [sentence(finding.found[0])]
    for each in finding.found[1:]:
        also = "also missing: " if isinstance(each, MissingTerm) else ""
        texts.append(f"{also}{sentence(each)}")
    text = one_after_another(texts)
    if finding.may_be_long_delay:
        text += (
            ". The delay or lag that is declared too long may cause this (see alignment). Correct "
            "it first"
        )
    return text


@sentence.register
def missing_term(finding: MissingTerm) -> str:
    """Return the term with its size and share of the force, and the element to declare."""
    text = f"{_statement(finding)}. {capitalised(_advice(finding.term, finding))}"
    for other in finding.others:
        name = _filled(_words_of(other).name, other, finding)
        text += f". Alternatively, {name} explains nearly as much: {_advice(other, finding)}"
    return text


@sentence.register
def changed_parameter(finding: ChangedParameter) -> str:
    """Return the change of a parameter, and how to avoid it."""
    name = "the drive gain" if finding.is_gain else f"the parameter {finding.parameter}"
    part = share_text(finding.share)
    if finding.change == "held":
        more = "larger" if finding.size > 0 else "smaller"
        size = f"{abs(finding.size):.3g} +- {finding.standard_error:.1g} {finding.unit}".rstrip()
        return (
            f"{name} is {size} {more} than the given value ({part}). Correct this value, or "
            "estimate it"
        )
    change = _size(finding.size, finding.standard_error, finding.unit)
    if finding.percent is not None:
        change += f" ({finding.percent:+.2g} %)"
    if finding.change == "drift":
        return (
            f"{name} drifts with time: {change} over the record, {part}. Record when the axis is "
            "warm, or identify parts of the record separately"
        )
    return (
        f"{name} changes by {change} from about {finding.seconds:.3g} s on, {part}. Identify the "
        "record before and after that time separately, or find what was changed then"
    )


@sentence.register
def moved_parameter(finding: MovedParameter) -> str:
    """Return how far a parameter is off."""
    if finding.is_changing:
        change = (
            f"{finding.parameter} changes by {finding.percent:.2g} % of its value in the record"
        )
    else:
        change = (
            f"a missing term of the model changes {finding.parameter} by {finding.percent:.2g} % "
            "of its value"
        )
    return (
        f"{change}, and a value that is more than {finding.most_percent:g} % off must not be used. "
        "Correct the model or the record first"
    )


def share_text(share: ShareOfForce) -> str:
    """Return the share of the force, with the part that the declared terms cannot explain."""
    if share.percent > 100:
        whole = "more than the force itself"
    else:
        whole = f"{share.percent:.2g} % of the force"
    beyond = f"{share.beyond_percent:.2g} %"
    if whole.startswith(beyond):
        return whole
    return f"{whole}; the declared terms cannot explain {beyond}"


def _statement(finding: MissingTerm) -> str:
    """Return that a term is missing, its size, and its share of the force."""
    words = _words_of(finding.term, is_negative=finding.size < 0)
    text = _filled(words.said, finding.term, finding)
    # A size larger than the force is one that the model's own parameters cancel.
    if finding.unit and finding.share.percent <= 100:
        size = _size(finding.size, finding.standard_error, finding.unit)
        text += f": {words.size.format(size=size)}"
    return f"{text}, {share_text(finding.share)}"


def _advice(term: CandidateTerm, finding: MissingTerm) -> str:
    """Return the instruction for a term, which begins with a small letter."""
    if term.is_declared:
        return f"declare another velocity or exponent of {term.kind}"
    is_negative = term is finding.term and finding.size < 0
    return _filled(_words_of(term, is_negative=is_negative).advice, term, finding)


def _words_of(term: CandidateTerm, *, is_negative: bool = False) -> _Words:
    """Return the words of a built-in term, or those that a term of the user's own has."""
    if term.what or term.declare:
        return _Words(
            name=term.what or term.kind,
            statement=term.what or term.kind,
            advice=term.declare or "declare it",
        )
    if term.kind not in _WORDS:
        kind = repr(term.kind).replace("{", "{{").replace("}", "}}")
        return _Words(name=f"the term {kind}", advice="declare it")
    if term.kind == "delay" and is_negative:
        return _EARLY
    return _WORDS[term.kind]


def _filled(text: str, term: CandidateTerm, finding: MissingTerm) -> str:
    """Return a text with the numbers of a term, and with the units of the axis."""
    cutoff, dead_band, limit = term.cutoff or 0.0, term.dead_band or 0.0, term.limit or 0.0
    return text.format(
        q=finding.coordinate,
        unit=finding.coordinate_unit,
        drive=finding.drive_unit,
        force=finding.force_unit,
        at=term.at or 0.0,
        rigid=cutoff,
        band=dead_band,
        limit=limit,
        side="higher" if finding.size > 0 else "lower",
        cutoff=setting("cutoff", f"{cutoff:.2g}"),
        dead_band=_drive_setting("deadband", term.dead_band, finding.drive_unit),
        limit_set=_drive_setting("limit", term.limit, finding.drive_unit),
    )


def _drive_setting(key: str, value: float | None, unit: str) -> str:
    """Return how a number of the drive is declared; empty where it is not known."""
    if value is None:
        return ""
    return (
        f" in {unit} ({key} = {value:.2g} in the table [drive] of TOML, or "
        f"Drive({key}={value:.2g}) in Python)"
    )


def _size(size: float, standard_error: float, unit: str) -> str:
    return f"{size:+.3g} +- {standard_error:.1g} {unit}".rstrip()
