"""Sentences of missing terms of a model, and of parameters that change or have wrong values."""

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
    """Words of a term, with placeholders for its numbers, units and the coordinate's name.

    Attributes
    ----------
    name : str
        Name of the force.
    advice : str
        Instruction, which begins with a verb.
    statement : str
        Statement that the term is missing; if empty, it is formed from the name.
    size : str
        Text on the size of the term, with the placeholder ``{size}``.
    alternative : str
        Instruction to declare the term instead of another one; if empty, it is the advice.
    """

    name: str
    advice: str
    statement: str = ""
    size: str = "{size}"
    alternative: str = ""

    @property
    def missing_statement(self) -> str:
        """Return the statement that the term is missing."""
        return self.statement or f"{self.name} is missing"


_ADD_STRIBECK = "add stribeck(Fs, {q}, velocity={at:.1g}, exponent=1) to the model"
#: Words by kind of the built-in terms.
_WORDS: Mapping[str, _Words] = {
    "constant": _Words(name="a constant force", advice="add offset(F0) to the model"),
    "coulomb": _Words(name="Coulomb friction", advice="add coulomb(Fc, {q}) to the model"),
    "viscous": _Words(name="viscous friction", advice="add viscous(Fv, {q}) to the model"),
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
        advice="add quadratic(Fq, {q}) to the model, or a Stribeck peak (stribeck) if friction "
        "differs at low speed",
    ),
    "stribeck": _Words(
        name="friction that is higher or lower at speeds up to about {at:.1g} {unit}/s than above",
        statement="friction is {side} at speeds up to about {at:.1g} {unit}/s",
        advice=f"{_ADD_STRIBECK}, in addition to coulomb",
        alternative=_ADD_STRIBECK,
    ),
    "slope": _Words(
        name="a force proportional to the position", advice="add spring(k, {q}) to the model"
    ),
    "bend": _Words(
        name="a force proportional to the square of the position",
        advice="add offset(kq*{q}**2) to the model",
    ),
    "turn": _Words(
        name="a torque with a period of one turn",
        advice="add gravity_moment(a, b, {q}) to the model",
    ),
    "place": _Words(
        name="a force that is periodic in the position (every {at:.3g} {unit})",
        advice="add cogging(a, b, {q}, period={at:.3g}) to the model",
    ),
    "friction slope": _Words(
        name="friction that depends linearly on the position",
        statement="friction depends linearly on the position",
        advice="add coulomb(Fq*{q}, {q}) to the friction of the model",
    ),
    "friction bend": _Words(
        name="friction that depends on the square of the position",
        statement="friction depends on the square of the position",
        advice="add coulomb(Fq*{q}**2, {q}) to the friction of the model",
    ),
    "friction place": _Words(
        name="friction that is periodic in the position (every {at:.3g} {unit})",
        statement="friction is periodic in the position (every {at:.3g} {unit})",
        advice="add periodic_coulomb(a, b, {q}, period={at:.3g}) to the model",
    ),
    "resonance": _Words(
        name="a resonance with an antiresonance near {at:.2g} Hz",
        statement="the axis has a resonance with an antiresonance near {at:.2g} Hz, and a rigid "
        "model is valid up to about {rigid:.2g} Hz",
        advice="lower the cut-off of identify to this frequency ({cutoff}), or record slower "
        "motions",
    ),
    "delay": _Words(
        name="a lag, a delay or a rate limit of the drive",
        statement="the drive has another lag or delay than declared, or a rate limit that noise "
        "reaches",
        advice="declare the lag, delay or rate limit of the drive, or move the column that is late",
    ),
    "loss": _Words(
        name="a load-dependent loss",
        statement="the load causes a loss: the drive gives less force when it drives the load, and "
        "more when it brakes the load",
        advice="compare the share of this force with the accuracy that you need, because no "
        "element describes the loss",
    ),
    "presliding": _Words(
        name="friction that differs just after a velocity reversal (pre-sliding)",
        statement="friction is higher or lower just after a velocity reversal (pre-sliding)",
        advice="add a bristle model (dahl or lugre), or exclude more samples near the reversals",
    ),
    "backlash": _Words(
        name="a force that is late at its change of sign (backlash)",
        statement="the force is late where it changes its sign (backlash, play)",
        advice="remove the play, or record motions in which the force keeps its sign",
    ),
    "dead band": _Words(
        name="a dead band of the drive",
        statement="the drive gives less force than the control commands, in both directions",
        advice="declare the dead band of the drive{dead_band}",
    ),
    "saturation": _Words(
        name="a limit of the drive at about {at:.2g} {force}",
        statement="the drive gives no more than about {at:.2g} {force}, whatever the control "
        "commands",
        advice="declare the limit of the drive{limit_set}, or record motions with less force",
    ),
}
#: Words of a negative delay.
_EARLY = _Words(
    name="a force that acts before the recorded control",
    statement="a force acts before the recorded control: the control lacks a feed-forward, a delay "
    "or lag is declared too long, or a column is late",
    advice="record the control with the feed-forward, correct the declared drive, or move the "
    "column",
)


@sentence.register
def missing_terms(finding: MissingTerms) -> str:
    """Return the sentences of all missing terms, the largest part of the force first.

    Several are numbered, after the instruction to correct one at a time.
    """
    if not finding.found:
        return "the residual contains none of the terms that were tested"
    texts = [sentence(each) for each in finding.found]
    if len(texts) > 1:
        texts = [
            f"{len(texts)} errors of the model were found. Correct the first one, and identify "
            "again before you correct the next one",
            *(f"({i}) {capitalised(text)}" for i, text in enumerate(texts, 1)),
        ]
    text = one_after_another(texts)
    if finding.may_be_long_delay:
        text += (
            ". The delay or lag that is declared too long may cause this (see alignment). Correct "
            "this delay or lag first"
        )
    return text


@sentence.register
def missing_term(finding: MissingTerm) -> str:
    """Return the term with its size and share of the force, and the element to add.

    Alternatives are terms that explain nearly as much of the force.
    """
    text = f"{_statement(finding)}. {capitalised(_advice(finding.term, finding))}"
    first = term_name(finding)
    for other in finding.others:
        name = _filled(_words_of(other).name, other, finding)
        text += (
            f". As an alternative to {first}, {_advice(other, finding)}: {name} explains nearly as "
            "much of the force"
        )
    return text


def term_name(finding: MissingTerm) -> str:
    """Return the name of a missing term: ``Coulomb friction``."""
    words = _words_of(finding.term, is_negative=finding.size < 0)
    return _filled(words.name, finding.term, finding)


@sentence.register
def changed_parameter(finding: ChangedParameter) -> str:
    """Return the change of a parameter, and the instruction to correct or avoid it.

    It is the error of a fixed value, a slow drift over the record, or a sudden change.
    """
    name = "the drive gain" if finding.is_gain else f"the parameter {finding.parameter}"
    part = f"The effect on the force is {share_text(finding.share)}"
    if finding.change == "held":
        more = "larger" if finding.size > 0 else "smaller"
        size = f"{abs(finding.size):.3g} +- {finding.standard_error:.1g} {finding.unit}".rstrip()
        return (
            f"{name} is {size} {more} than the given value. {part}. Correct this value, or "
            "estimate it"
        )
    change = _size(finding.size, finding.standard_error, finding.unit)
    if finding.percent is not None:
        change += f" ({finding.percent:+.2g} %)"
    if finding.change == "drift":
        return (
            f"{name} drifts with time: {change} over the record. {part}. Record when the axis is "
            "warm, or identify parts of the record separately"
        )
    return (
        f"{name} changes by {change} from about {finding.seconds:.3g} s on. {part}. Identify the "
        "parts before and after this time separately, or find the change of the machine"
    )


@sentence.register
def moved_parameter(finding: MovedParameter) -> str:
    """Return the error or change of a parameter that is too large, with the threshold.

    A change by a missing term has the name of the term, and the values with this term and with all
    missing terms, if the finding has them.
    """
    name, percent = finding.parameter, f"{finding.percent:.2g} % of its value"
    limit = f"The limit is {finding.most_percent:g} %"
    end = f"Do not use {name}. First correct the model, or the record if the record is wrong"
    if finding.is_changing:
        return f"{name} changes by {percent} in the record. {limit}. {end}"
    change = f"a missing term changes {name} by {percent}"
    if isinstance(finding.cause, MissingTerm):
        change = (
            f"{term_name(finding.cause)} is missing. With this term, {name} changes by {percent}"
        )
    with_all = ""
    if finding.values is not None:
        before, after, last = (f"{value:.3g}" for value in finding.values)
        change += f", from {before} to {after} {finding.unit}".rstrip()
        if last != after:
            with_all = f" With all missing terms, {name} is {last} {finding.unit}".rstrip() + "."
    return f"{change}.{with_all} {limit}. {end}"


def share_text(share: ShareOfForce) -> str:
    """Return the share of the force, then a sentence on the share that remains unexplained.

    The other parameters of the model compensate for the rest. Equal shares are printed once.
    """
    if share.percent > 100:
        whole = "more than 100 % of the force (rms)"
    else:
        whole = f"{share.percent:.2g} % of the force (rms)"
    beyond = f"{share.beyond_percent:.2g} %"
    if whole.startswith(beyond):
        return whole
    return (
        f"{whole}. The other parameters compensate for a part, and {beyond} of the force remains "
        "unexplained"
    )


def _statement(finding: MissingTerm) -> str:
    """Return the statement that a term is missing, with its size and share of the force."""
    words = _words_of(finding.term, is_negative=finding.size < 0)
    text = _filled(words.missing_statement, finding.term, finding)
    # A term larger than the force itself is nearly cancelled by the declared terms, so its size
    # has no meaning.
    if finding.unit and finding.share.percent <= 100:
        size = _size(finding.size, finding.standard_error, finding.unit)
        text = f"{text}: {words.size.format(size=size)}"
        return f"{text}. The missing force is {share_text(finding.share)}"
    return f"{text}. The unmodelled force is {share_text(finding.share)}"


def _advice(term: CandidateTerm, finding: MissingTerm) -> str:
    """Return the instruction for a term, which begins with a small letter."""
    if term.is_declared:
        return f"declare another velocity or exponent of {term.kind}"
    if term is not finding.term:
        words = _words_of(term)
        return _filled(words.alternative or words.advice, term, finding)
    words = _words_of(term, is_negative=finding.size < 0)
    return _filled(words.advice, term, finding)


def _words_of(term: CandidateTerm, *, is_negative: bool = False) -> _Words:
    """Return the words of a built-in term, or the words that a user's own term brings with it."""
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
    """Return a text whose placeholders are filled with the numbers of a term and the units."""
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
    """Return the declaration of a number of the drive as text; empty if the number is None."""
    if value is None:
        return ""
    return (
        f" in {unit} ({key} = {value:.2g} in the table [drive] of TOML, or "
        f"Drive({key}={value:.2g}) in Python)"
    )


def _size(size: float, standard_error: float, unit: str) -> str:
    """Return a signed size with its standard error and unit: ``+2.5 +- 0.1 N``."""
    return f"{size:+.3g} +- {standard_error:.1g} {unit}".rstrip()
