"""Several records of one machine: the drive gain by a payload, offsets of each, whether all agree.

Twins of a stage with the paper's parameters and encoder noise: pairs of records without and with a
known payload, whose gain is declared 2 % wrong; four records with an offset of the amplifier each;
three records of which none, or the last, has another mass. Every estimate is by IDM-IV under the
default filter, every interval of 95 % and HAC.

    python benchmarks/records.py --runs 30
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from figures import give, parser_of

from axisid import Record, identify, load_axis
from axisid.codegen.generated_axes import GeneratedAxis, build
from axisid.estimation.diagnostics import RecordDifference, pooling_test
from axisid.estimation.simulation import twin_record
from axisid.estimation.verdict_checks import DEFAULT_LEVELS
from axisid.modeling.declaration import Axis, leave_out
from axisid.modeling.quantities import Parameter
from axisid.support.missing import Missing

PAYLOADS = (0.05, 0.2, 0.5)  # of the mass
WRONG_GAIN = 1.02
OFFSETS = (3.5, -5.0, 7.0, 10.0)  # N: 100 to 300 mV
OTHER_MASSES = (0.01, 0.02, 0.05, 0.2)  # of the mass
METHOD = "idm-iv"


@cache
def stage() -> Axis:
    """The paper's axis with an offset and a payload."""
    axis = load_axis("emps2015")
    payload, offset = Parameter("m_add", "kg", lower=0.0), Parameter("tau0", "N")
    assert axis.experiment is not None
    truth = {**axis.experiment.truth, "m_add": 0.0, "tau0": 0.0}
    return replace(
        axis,
        name="stage",
        parameters=(*axis.parameters, offset, payload),
        force=axis.force + payload * axis.coordinate.acceleration + offset.symbol,
        experiment=replace(axis.experiment, truth=truth),
    )


@cache
def machine(gain: float) -> GeneratedAxis:
    """The stage with a drive of some gain, the payload among its base parameters."""
    return build(replace(stage(), drive=replace(stage().drive, gain=gain)))


@cache
def plain() -> GeneratedAxis:
    """The stage without offset and payload."""
    return build(leave_out(stage(), "tau0", "m_add"))


def twin(seed: int, gain: float, **truth: float) -> Record:
    """A record of the machine, with other parameters than the paper's where they are given."""
    axis = machine(gain)
    experiment = axis.declared.experiment
    assert experiment is not None
    told = replace(experiment, seed=seed, truth={**experiment.truth, **truth})
    base = axis.base.at([told.truth[p.name] for p in axis.declared.parameters])
    named = dict(zip((p.name for p in axis.axis.parameters), base, strict=True))
    own = replace(axis.axis, experiment=replace(told, truth=named))
    return twin_record(replace(axis, axis=own))


def _truth(name: str) -> float:
    """The true value of a parameter of the stage."""
    experiment = stage().experiment
    assert experiment is not None
    return float(experiment.truth[name])


def by_payload(share: float, runs: int) -> dict[str, float]:
    """The drive gain by pairs of records, the second with a payload that is a share of the mass."""
    declared = stage().drive.gain
    mass = _truth("M")
    gains, claimed, held = [], [], 0
    masses = []
    for run in range(runs):
        pair = [
            twin(2 * run + i, declared * WRONG_GAIN, m_add=i * share * mass, tau0=0.0)
            for i in range(2)
        ]
        known = {"m_add": [0.0, share * mass]}
        found = identify(machine(declared), pair, methods=[METHOD], known=known, judge=False)[
            METHOD
        ]
        value = found.parameters["drive_gain"]
        gains.append(value.corrected)
        claimed.append(value.deviation)
        low, high = value.interval
        held += low <= declared * WRONG_GAIN <= high
        masses.append(found.parameters["M"].corrected)
    truth = declared * WRONG_GAIN
    return {
        "runs": runs,
        "sd_percent": 100 * float(np.std(gains, ddof=1)) / truth,
        "claimed_sd_percent": 100 * float(np.mean(claimed)) / truth,
        "bias_in_standard_errors": _bias(gains, truth),
        "coverage": held / runs,
        "mass_sd_percent": 100 * float(np.std(masses, ddof=1)) / mass,
        "mass_bias_in_standard_errors": _bias(masses, mass),
    }


def _bias(values: Sequence[float], truth: float) -> float:
    error = float(np.std(values, ddof=1)) / len(values) ** 0.5
    return (float(np.mean(values)) - truth) / error


def by_locals(runs: int) -> dict[str, float]:
    """The mass by four records with an offset each against by one, and the offsets themselves."""
    gain = stage().drive.gain
    axis = build(leave_out(stage(), "m_add"))
    together, alone, offsets, held = [], [], [], 0
    for run in range(runs):
        records = [twin(1000 + 4 * run + i, gain, tau0=x) for i, x in enumerate(OFFSETS)]
        found = identify(axis, records, methods=[METHOD], local="tau0", judge=False)
        together.append(found[METHOD].parameters["M"].corrected)
        one = identify(axis, records[0], methods=[METHOD], judge=False)[METHOD]
        alone.append(one.parameters["M"].corrected)
        for value, truth in zip(found.local["tau0"], OFFSETS, strict=True):
            offsets.append(value.corrected - truth)
            held += value.interval[0] <= truth <= value.interval[1]
    return {
        "runs": runs,
        "mass_sd_of_four": float(np.std(together, ddof=1)),
        "mass_sd_of_one": float(np.std(alone, ddof=1)),
        "mass_bias_in_standard_errors": _bias(together, _truth("M")),
        "offset_error_rms_mV": 1e3 * float(np.sqrt(np.mean(np.square(offsets)))) / gain,
        "offset_coverage": held / (4 * runs),
    }


def by_equality(other: float, runs: int) -> dict[str, float]:
    """How often one of three records speaks against the rest, the last's mass a share larger."""
    gain, mass = stage().drive.gain, _truth("M")
    rejected, named, mass_alone, chances = 0, 0, 0, []
    for run in range(runs):
        records = [
            twin(5000 + 3 * run + i, gain, M=mass * (1 + other * (i == 2))) for i in range(3)
        ]
        result = identify(plain(), records, methods=[METHOD])
        found = pooling_test(result.problem, result[METHOD])
        if isinstance(found, Missing):
            raise SystemExit(f"the records cannot be told apart: {found}")
        odd = None if found.odd is None else found.records[found.odd]
        if isinstance(odd, RecordDifference):
            rejected += odd.matters(DEFAULT_LEVELS)
            named += found.odd == 2
            mass_alone += odd.differing(DEFAULT_LEVELS) == ("M",)
        chances.append(found.p_value)
    return {
        "runs": runs,
        "fails": rejected / runs,
        "names_the_right_one": named / runs,
        "names_the_mass_alone": mass_alone / runs,
        "least_chance": float(min(chances)),
    }


def main() -> None:
    """Print the figures, or write them as JSON."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=30)
    options = parser.parse_args()
    figures: dict[str, object] = {
        f"payload {share:g}": by_payload(share, options.runs) for share in PAYLOADS
    }
    figures["local offsets"] = by_locals(options.runs)
    for other in (0.0, *OTHER_MASSES):
        figures[f"mass {other:g} larger"] = by_equality(other, options.runs)
    lines = (
        f"{name:20} " + "  ".join(f"{key} {value:.4g}" for key, value in found.items())
        for name, found in figures.items()
        if isinstance(found, dict)
    )
    give(figures, options.json, lines)


if __name__ == "__main__":
    main()
