"""Instruments against DIDIM, and which of the two to believe, as a check."""

from collections.abc import Mapping, Sequence

from axisid.estimation.checks import Check, passed
from axisid.estimation.estimates import Estimate, Value
from axisid.estimation.noise import NoiseBias
from axisid.estimation.thresholds import (
    CONTRADICTION_LEVEL,
    MAX_RELATIVE_DEVIATION,
    MAX_UNSEEN_BIAS,
    MIN_GAIN_OF_PRECISION,
    NEGLIGIBLE_BIAS,
)
from axisid.support.missing import Missing

NAME = "second opinion"


def second_opinion_check(
    found: Mapping[str, NoiseBias] | Missing | None,
    iv: Estimate | None,
    didim: Estimate | None,
    *,
    law_passed: bool | None,
) -> Check | Missing | None:
    """Whether instruments without its bias and DIDIM are one estimate but for chance.

    Parameters
    ----------
    found : mapping of str to NoiseBias, or Missing or None
        Instruments less DIDIM by parameter; None where they are not there both.
    iv, didim : Estimate or None
    law_passed : bool or None
        Whether the recorded control is the declared law's; None where that cannot be checked.
    """
    if found is None or iv is None or didim is None:
        return None
    if isinstance(found, Missing):
        return found
    moved = _moved(found)
    both = {name: (iv.parameters[name], didim.parameters[name]) for name in moved}
    large = [name for name, each in moved.items() if _is_large(each, *both[name])]
    vague = _vague(iv, didim) if law_passed and not moved else ""
    worst = max((moved or found).values(), key=lambda each: each.shift)
    return Check(
        name=NAME,
        status=passed(not (moved or vague), matters=bool(large)),
        figure=worst.shift,
        threshold=MAX_UNSEEN_BIAS.value,
        p_value=worst.joint_p_value,
        source="largest difference of idm-iv, less its bias, and didim, in deviations "
        "of didim; counts where a HAC test of all differences at once (Hotelling, the p-value) "
        "rejects at 1 %; a note up to 1 % of the value, where the 95 % interval of either allows "
        "for it, as an encoder's steps widen them, and where idm-iv is much the vaguer",
        meaning=_apart(moved, both, law_passed=law_passed)
        if moved
        else "idm-iv and didim, whose regressor has no noise and no filter's error, are one "
        f"estimate but for chance or what does not matter{vague}",
    )


def prefers_instruments(found: Mapping[str, NoiseBias], iv: Estimate, didim: Estimate) -> bool:
    """Whether instruments are to be believed though the control is the law's: see `_whom`."""
    moved = _moved(found)
    return bool(_vaguer({name: (iv.parameters[name], didim.parameters[name]) for name in moved}))


def _vaguer(both: Mapping[str, tuple[Value, Value]]) -> list[str]:
    """What didim, the second, knows less of among the parameters that the two part in."""
    return [name for name, (iv, didim) in both.items() if didim.deviation > iv.deviation]


def _moved(found: Mapping[str, NoiseBias]) -> dict[str, NoiseBias]:
    """Parameters that the two part in: those that do alone, or else together.

    What one gives to another, as friction's two parts do, neither of them need show by itself.
    """
    level = CONTRADICTION_LEVEL.value
    far = {
        name: each
        for name, each in found.items()
        if each.joint_p_value < level and each.shift > MAX_UNSEEN_BIAS.value
    }
    return {name: each for name, each in far.items() if each.p_value < level} or far


def _vague(iv: Estimate, didim: Estimate) -> str:
    """What didim tells much more precisely; empty where it gains little."""
    least = 100 * NEGLIGIBLE_BIAS.value
    gains = {
        name: value.deviation / didim.parameters[name].deviation
        for name, value in iv.parameters.items()
        if value.relative_deviation_percent > least and didim.parameters[name].deviation > 0
    }
    name = max(gains, key=lambda each: gains[each], default="")
    if not name or gains[name] < MIN_GAIN_OF_PRECISION.value:
        return ""
    return (
        f"; idm-iv tells {name} to {iv.parameters[name].relative_deviation_percent:.2g} %, didim "
        f"to {didim.parameters[name].relative_deviation_percent:.2g} %: the control is the "
        "declared law's, so take didim"
    )


def _is_large(bias: NoiseBias, iv: Value, didim: Value) -> bool:
    """Whether a known parameter is another by more than either interval allows for."""
    apart = abs(bias.difference)
    precise = iv.relative_deviation_percent < MAX_RELATIVE_DEVIATION.value
    widest = max(value.interval[1] - value.interval[0] for value in (iv, didim))
    return precise and apart > widest / 2 and apart > NEGLIGIBLE_BIAS.value * abs(iv.value)


def _apart(
    moved: Mapping[str, NoiseBias],
    both: Mapping[str, tuple[Value, Value]],
    *,
    law_passed: bool | None,
) -> str:
    listed = ", ".join(
        f"{name} by {bias.difference:+.2g} {both[name][1].unit} "
        f"({_percent(bias, both[name][1])}{bias.shift:.2g} deviations)"
        for name, bias in moved.items()
    )
    vaguer = _vaguer(both)
    return f"idm-iv differs from didim, {listed}: {_whom(law_passed=law_passed, vaguer=vaguer)}"


def _percent(bias: NoiseBias, didim: Value) -> str:
    return f"{100 * bias.difference / didim.value:+.2g} %, " if didim.value else ""


def _whom(*, law_passed: bool | None, vaguer: Sequence[str]) -> str:
    """Which of the two a control law speaks for, on which didim alone rests, `vaguer` of some."""
    if law_passed and vaguer:
        return (
            "the encoder's steps, or a force that the model lacks, move both, and didim is the "
            f"vaguer in {', '.join(vaguer)}, so the verdict is of the instruments"
        )
    if law_passed:
        return (
            "the control is the declared law's, so believe didim; a coarse encoder or a filter "
            "that does not suit moves the instruments, a force that the model lacks moves both"
        )
    why = "could not be checked" if law_passed is None else "is not the declared one"
    return f"the control law {why}, on which didim rests, so believe the instruments"
