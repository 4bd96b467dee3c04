"""What the diagnostics say about a real record: the DFKI pendulum's identification run.

Run it: python examples/dfki_pendulum_study.py DATA_FOLDER --output FOLDER

It joins the run's measured and desired files into one record, prints the tables of
docs/dfki_pendulum.md and draws its figures (`dfki_pendulum_figures.py`). Assumed, and not in the
data: row k of the desired file is what was commanded at row k of the measured file; the drive's law
and gains are those of `dfki_pendulum.py`; the recorded torque is that of the output shaft at the
sample's instant, so that `hold` is raw.
"""

import argparse
import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from dfki_pendulum import axis, drive_law
from dfki_pendulum_data import (
    DOCUMENTED,
    MOTIONS,
    PUBLISHED,
    Array,
    Data,
    authors_recipe,
    columns_by_hand,
    derivative,
    facts,
    high_pass,
    percent,
    prefilter,
    read_data,
    weak_form,
)
from scipy import signal

from axisid import (
    DataError,
    Estimate,
    Identification,
    Prefilter,
    Record,
    identify,
    simulate,
    sweep,
    validate,
)
from axisid.estimation import Check

CUTOFFS = (3.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 60.0)  # Hz
SHOWN = 15.0  # Hz, the lowest cut-off of the authors' recipe

Rows = list[list[str]]


def recipe_table(data: Data) -> Rows:
    """The authors' recipe with other edges of its low-pass, and on the motion recorded anew."""
    rows = []
    for name in ("identification run", "direct collocation"):
        record = data.records[name]
        for share in (0.02, 0.033, 0.05, 0.1, 0.15):
            theta, error = authors_recipe(record, data.velocity[name], share)
            edge = f"{share * 0.5 / record.period:.1f}"
            rows.append([name, edge, f"{theta[0]:.4f}", f"{theta[1]:.4f}", f"{error:.1f}"])
    return rows


def sweep_results(data: Data, record: Record | None = None) -> tuple[Identification, ...]:
    """All methods at every cut-off."""
    base = Prefilter(hold="raw")
    return sweep(axis, record or data.run, CUTOFFS, base).results


def check_of(result: Identification, name: str) -> Check:
    """One check of the verdict."""
    return next(check for check in result.verdict if check.name == name)


def sweep_table(results: Sequence[Identification]) -> Rows:
    """Values with HAC deviations, and what the checks say of them."""
    rows = []
    for result in results:
        row = [f"{result.prefilter.cutoff:g}"]
        for name in ("J", "mc"):
            row += [_value(result.estimates.get(m), name) for m in ("idm-ls", "ddm-ls", "idm-iv")]
        strength = check_of(result, "instrument strength")
        compared = check_of(result, "least squares against instruments")
        p = f"{compared.p_value:.0e}" if compared.p_value is not None else "-"
        rows.append([*row, f"{strength.figure:.3g}, {strength.status}", p])
    return rows


def _value(estimate: Estimate | None, name: str) -> str:
    if estimate is None:
        return "-"
    value = estimate.parameters[name]
    return f"{value.value:.3f} +- {value.sd_hac:.3f}"


def gains_table(data: Data, cutoff: float = SHOWN) -> Rows:
    """How the instruments' estimate moves with what is assumed about the law."""
    late = np.concatenate([[0.0], np.asarray(data.run.reference)[:-1]])
    cases = [(p, d, False) for p, d in _GAINS] + [(50.0, 4.0, True)]
    rows = []
    for p, d, delayed in cases:
        assumed = replace(axis, control=drive_law(p, d))
        record = replace(data.run, reference=late) if delayed else data.run
        name = f"{p:g} / {d:g}" + (", reference one sample late" if delayed else "")
        result = identify(assumed, record, prefilter(record, cutoff), ["idm-iv"])
        estimate, (held,) = result["idm-iv"], validate(result, record)
        off = 1e3 * (held.position_error_rms or math.nan)
        strength = f"{check_of(result, 'instrument strength').figure:.3g}"
        values = [_value(estimate, "J"), _value(estimate, "mc")]
        rows.append([name, *values, strength, f"{off:.1f}"])
    return rows


_GAINS = ((50, 4), (40, 4), (60, 4), (50, 3.2), (50, 4.8), (40, 3.2), (60, 4.8), (25, 2), (100, 8))


def delayed(record: Record, samples: float) -> Record:
    """The record with its torque taken so many samples earlier."""
    torque, at = np.asarray(record.control), np.arange(len(record), dtype=float)
    return replace(record, control=np.interp(at - samples, at, torque))


def delay_profile(record: Record, cutoff: float, delays: Array) -> tuple[Array, Array]:
    """Equation error in percent and estimate of least squares over the delay, in s."""
    settings = prefilter(record, cutoff)
    record = replace(record, reference=None)  # no simulation is needed
    estimates = [
        identify(axis, delayed(record, d / record.period), settings, ["idm-ls"])["idm-ls"]
        for d in delays
    ]
    return (
        np.array([e.equation_error_percent for e in estimates]),
        np.array([e.physical for e in estimates]),
    )


DELAYS = np.arange(-12.0, 36.1, 2.0) * 1e-3  # s


def delay_table(data: Data) -> Rows:
    """Where the equation error is smallest, and what that place is worth."""
    rows = []
    for name, record in data.records.items():
        for cutoff in (3.0, 5.0, 8.0, 15.0):
            errors, physical = delay_profile(record, cutoff, DELAYS)
            best, none = int(errors.argmin()), int(np.abs(DELAYS).argmin())
            row = [name, f"{cutoff:g}", f"{1e3 * DELAYS[best]:.0f}"]
            row += [f"{errors[best]:.1f}", f"{errors[none]:.1f}"]
            rows.append([*row, f"{physical[none, 1]:.3f}", f"{physical[best, 1]:.3f}"])
    return rows


def twin_delays(twins: Sequence[Data], cutoff: float) -> tuple[Array, Array]:
    """Best delay of each twin, s, whose torque has none; and the profiles, (twins, delays)."""
    profiles = np.array([delay_profile(one.run, cutoff, DELAYS)[0] for one in twins])
    return DELAYS[profiles.argmin(axis=1)], profiles


def twin_delay_table(twins: Sequence[Data]) -> Rows:
    """What the same search finds where there is no delay."""
    rows = []
    for cutoff in (3.0, 5.0, 8.0, 15.0):
        best = 1e3 * twin_delays(twins, cutoff)[0]
        listed = ", ".join(f"{b:.0f}" for b in sorted(best))
        rows.append([f"{cutoff:g}", f"{best.mean():.0f} +- {best.std():.0f}", listed])
    return rows


def candidates(data: Data) -> Iterator[tuple[str, Identification | Array]]:
    """What is held against every motion: published values, then this study's."""
    yield "published", PUBLISHED
    for method in ("idm-ls", "idm-iv"):
        result = identify(axis, data.run, prefilter(data.run, SHOWN), [method])
        yield f"{method.upper()}, {SHOWN:g} Hz", result


def validation_table(data: Data, cutoff: float = 5.0) -> Rows:
    """Equation error of frozen estimates on each motion, in percent, both filtered at `cutoff`."""
    rows = []
    for name, candidate in candidates(data):
        row = [name]
        for record in data.records.values():
            settings = prefilter(record, cutoff)
            if isinstance(candidate, Identification):
                # The other motions were sampled faster: the decimation must follow.
                (held,) = validate(replace(candidate, prefilter=settings), record)
                row.append(f"{held.equation_error_percent:.1f}")
            else:
                regressor, torque = columns_by_hand(record, settings)
                row.append(f"{percent(torque - regressor @ candidate, torque):.1f}")
        rows.append(row)
    return rows


def motions_table(data: Data, cutoff: float = 5.0) -> Rows:
    """Least squares on each motion by itself; J/mc is free of the torque's scale."""
    rows = []
    for name, record in data.records.items():
        estimate = identify(axis, record, prefilter(record, cutoff), ["idm-ls"])["idm-ls"]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            ratio = estimate.derive("J/mc")
        values = [_value(estimate, parameter) for parameter in ("J", "mc", "Fv", "Fc")]
        curved = " (curved)" if caught else ""  # the delta method says that it is not enough
        quotient = f"{ratio.value:.3f} +- {ratio.sd_hac:.3f}{curved}"
        rows.append([name, *values, quotient, f"{estimate.equation_error_percent:.1f}"])
    return rows


def weak_table(data: Data) -> Rows:
    """The same without derivatives and without axisid."""
    found = {name: weak_form(record) for name, record in data.records.items()}
    return [
        [name, f"{theta[0]:.3f}", f"{theta[1]:.3f}", f"{theta[0] / theta[1]:.3f}", f"{error:.1f}"]
        for name, (theta, error) in found.items()
    ]


def twin(data: Data, truth: Array, seed: int, *, shaken: bool = True, spiked: bool = True) -> Data:
    """The run simulated with known parameters, with what the record has beside such a motion.

    Parameters
    ----------
    data : Data
    truth : (5,) array
    seed : int
        Of the shuffle.
    shaken : bool
        Add to the position what the recorded one has above 5 Hz and the simulated one has not.
    spiked : bool
        Add to the torque what the recorded one has beside the truth's, its samples shuffled, so
        that no timing is left in it.
    """
    run = data.run
    loop = simulate(axis, truth, np.asarray(run.reference), run.period)
    position, torque = loop.position, loop.force
    if shaken:
        apart = run.position - loop.position
        position = position + signal.sosfiltfilt(high_pass(5.0, run.period), apart)
    if spiked:
        spikes = np.asarray(run.control) - loop.force
        torque = torque + np.random.default_rng(seed).permutation(spikes - spikes.mean())
    name = "identification run"
    record = replace(run, position=position, control=torque)
    return Data(records={name: record}, velocity={name: derivative(position, run.period)})


def twin_table(data: Data, truth: Array) -> Rows:
    """What each estimator makes of twins: mean and spread over ten shuffles."""
    rows = []
    for shaken, spiked in ((False, False), (True, False), (False, True), (True, True)):
        found: dict[str, list[Array]] = {}
        for seed in range(10 if spiked else 1):
            one = twin(data, truth, seed, shaken=shaken, spiked=spiked)
            theta, _ = authors_recipe(one.run, one.velocity["identification run"])
            result = identify(axis, one.run, prefilter(one.run, SHOWN), ["idm-ls", "idm-iv"])
            found.setdefault("recipe", []).append(theta)
            for method, estimate in result.estimates.items():
                found.setdefault(method, []).append(estimate.physical)
        added = " and ".join(["shaking"] * shaken + ["spikes"] * spiked) or "nothing"
        cells = (np.array(values) for values in found.values())
        rows.append([added, *(f"{_spread(c[:, 0])} / {_spread(c[:, 1])}" for c in cells)])
    return rows


def _spread(values: Array) -> str:
    return f"{values.mean():.3f}" + (f" +- {values.std():.3f}" if len(values) > 1 else "")


def table(title: str, header: str, rows: Rows) -> str:
    """One table as Markdown; the columns' names are separated by bars."""
    names = [name.strip() for name in header.split("|")]
    lines = [names, ["---"] * len(names), *rows]
    return "\n".join([f"{title}\n", *(f"| {' | '.join(line)} |" for line in lines), ""])


def report(data: Data, results: Sequence[Identification], twins: Sequence[Data]) -> str:
    """Every table of the document."""
    truth = shown(results)["idm-iv"].physical
    both = "J [kg m^2] | mc [kg m]"
    estimates = " | ".join(
        f"{name} {method}" for name in ("J", "mc") for method in ("IDM-LS", "DDM-LS", "IDM-IV")
    )
    best = "best [ms] | error there [%] | error at 0 [%] | mc at 0 | mc there"
    listed = [[name, f"{value:.4g}"] for name, value in facts(data).items()]
    return "\n".join(
        [
            table("The record", "what | figure", listed),
            f"documented: J = {DOCUMENTED['J']:.4f} kg m^2, mc = {DOCUMENTED['mc']:.4f} kg m\n",
            table("Recipe", f"record | edge [Hz] | {both} | error [%]", recipe_table(data)),
            table("Sweep", f"Hz | {estimates} | weakest F | p of LS = IV", sweep_table(results)),
            f"control law: {check_of(shown(results), 'control law').meaning}\n",
            table("Gains", f"p / d | {both} | weakest F | off [mrad]", gains_table(data)),
            table("Timing", f"record | Hz | {best}", delay_table(data)),
            table("Timing of twins", "Hz | best [ms] | each", twin_delay_table(twins)),
            table(
                "Motions", f"motion | {both} | Fv | Fc | J/mc [m] | error [%]", motions_table(data)
            ),
            table("Weak form", f"motion | {both} | J/mc [m] | error [%]", weak_table(data)),
            table("Validation", f"estimate | {' | '.join(MOTIONS)}", validation_table(data)),
            table("Twins", "added | recipe, J / mc | IDM-LS | IDM-IV", twin_table(data, truth)),
        ]
    )


def shown(results: Sequence[Identification]) -> Identification:
    """The sweep's result at the authors' lowest edge."""
    return next(result for result in results if result.prefilter.cutoff == SHOWN)


def main() -> None:
    """Print the tables and draw the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="folder with the pendulum's CSV files")
    parser.add_argument("--output", type=Path, default=Path("results"), help="for the figures")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    try:
        data = read_data(arguments.data, arguments.output)
    except (OSError, DataError) as error:
        raise SystemExit(f"the pendulum's records cannot be read: {error}") from error
    results = sweep_results(data)
    truth = shown(results)["idm-iv"].physical
    twins = [twin(data, truth, seed) for seed in range(10)]
    print(report(data, results, twins))

    from dfki_pendulum_figures import draw  # imports Matplotlib

    for path in draw(data, results, twins, arguments.output):
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
