"""What the diagnostics say about a real record: the DFKI pendulum's identification run.

Run it: python examples/dfki_pendulum_study.py DATA_FOLDER --output FOLDER

It joins the run's measured and desired files into one record, prints the tables of
docs/dfki_pendulum.md and of dfki_pendulum_tables.md, and draws the figures
(`dfki_pendulum_figures.py`). Assumed, and not in the data: row k of the desired file is what was
commanded at row k of the measured file; the drive's law and gains are those of `dfki_pendulum.py`;
the recorded torque is that of the output shaft at the sample's instant, so that `hold` is raw.
"""

import argparse
import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from dfki_pendulum import axis, drive_law
from dfki_pendulum_data import (
    DOCUMENTED,
    MOTIONS,
    PUBLISHED,
    SHOWN,
    Array,
    Data,
    Rows,
    authors_recipe,
    columns_by_hand,
    facts,
    instruments_by_hand,
    percent,
    prefilter,
    read_data,
    weak_form,
)
from dfki_pendulum_twins import delay_table, twin, twin_delay_table, twin_table
from scipy.special import stdtrit

from axisid import (
    DataError,
    Estimate,
    Identification,
    Prefilter,
    Record,
    identify,
    sweep,
    validate,
)
from axisid.estimation import Check, Hac
from axisid.estimation.regression import factor, instrumental_variables
from axisid.estimation.signals import SampledFilter

CUTOFFS = (3.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 60.0)  # Hz


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
    base = Prefilter(hold="raw", reversals="keep")
    return sweep(axis, record or data.run, CUTOFFS, base).results


def check_of(result: Identification, name: str) -> Check:
    """One check of the verdict."""
    return next(check for check in result.verdict if check.name == name)


def sweep_table(results: Sequence[Identification]) -> Rows:
    """Values with HAC deviations, and what the checks say of them."""
    rows = []
    for result in results:
        row = [f"{result.prefilter.cutoff:g}"]
        row.append(f"{len(result['idm-ls'].residuals)}")
        for name in ("J", "mc"):
            row += [_value(result.estimates.get(m), name) for m in ("idm-ls", "ddm-ls", "idm-iv")]
        strength = check_of(result, "instrument strength")
        compared = check_of(result, "method")
        p = f"{compared.p_value:.0e}" if compared.p_value is not None else "-"
        rows.append([*row, f"{_strength(strength.figure)}, {strength.status}", p])
    return rows


def _strength(f: float | None) -> str:
    if f is None:
        return "-"
    return f"{f:.0f}" if f >= 100 else f"{f:.2g}"


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
        strength = _strength(check_of(result, "instrument strength").figure)
        values = [_value(estimate, "J"), _value(estimate, "mc")]
        rows.append([name, *values, strength, f"{off:.1f}"])
    return rows


_GAINS = ((50, 4), (40, 4), (60, 4), (50, 3.2), (50, 4.8), (40, 3.2), (60, 4.8), (25, 2), (100, 8))


def stretch_table(data: Data, cutoff: float = SHOWN) -> Rows:
    """How the instruments' estimate moves with the stretch of the record that is kept."""
    settings = prefilter(data.run, cutoff)
    once, _ = SampledFilter(settings, data.run.period).dropped
    rows = []
    for start, end in ((0, 0), (1, 0), (0, 1), (1, 1), (2, 1), (1, 2), (2, 2), (3, 3)):
        ends = (start * once, end * once)
        theta, deviation, samples = stretch_estimate(data.run, settings, ends)
        row = [f"{ends[0]} / {ends[1]}", f"{samples}"]
        wide = float(stdtrit(samples - len(theta), 0.975)) * deviation
        for i in range(2):
            row.append(f"{theta[i]:.3f} +- {deviation[i]:.3f}")
            row.append(f"{theta[i] - wide[i]:.3f} to {theta[i] + wide[i]:.3f}")
        rows.append(row)
    return rows


def stretch_estimate(
    run: Record, settings: Prefilter, ends: tuple[int, int]
) -> tuple[Array, Array, int]:
    """IDM-IV on rows between ends without weight: estimate, HAC deviations, how many rows.

    `Prefilter.drop` would cut before the decimation filter, and so move the last sample's weight.
    """
    regressor, torque = columns_by_hand(run, settings, ends)
    theta = np.array([p.nominal or 0.0 for p in axis.parameters])
    names = [p.name for p in axis.parameters]
    for _ in range(6):  # it contracts by ten times and more in each
        instruments = instruments_by_hand(run, theta, settings, ends)
        factored = factor(regressor, names), factor(instruments, names)
        solution = instrumental_variables(torque, *factored)
        theta = solution.theta
    return theta, np.sqrt(np.diag(Hac().matrix(solution))), len(torque)


def frozen_error(record: Record, physical: Array, settings: Prefilter) -> float:
    """Equation error of given values on a record, in percent, without axisid's functions."""
    regressor, torque = columns_by_hand(record, settings)
    return percent(torque - regressor @ physical, torque)


def validation_table(data: Data) -> Rows:
    """Equation error in percent on each motion, of values that are frozen."""
    settings = prefilter(data.run, SHOWN)
    errors = [
        frozen_error(record, PUBLISHED, settings.at_period(data.run.period, record.period))
        for record in data.records.values()
    ]
    rows = [["published", *(f"{error:.1f}" for error in errors)]]
    for method in ("idm-ls", "idm-iv"):
        result = identify(axis, data.run, settings, [method], judge=False)
        held = [validate(result, record)[method] for record in data.records.values()]
        values = [f"{one.equation_error_percent:.1f}" for one in held]
        rows.append([f"{method.upper()}, {SHOWN:g} Hz", *values])
    return rows


def motions_table(data: Data) -> Rows:
    """Least squares on each motion by itself; J/mc is free of the torque's scale."""
    rows = []
    for name, record in data.records.items():
        for cutoff in (5.0, 8.0):
            estimate = identify(axis, record, prefilter(record, cutoff), ["idm-ls"], judge=False)[
                "idm-ls"
            ]
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                ratio = estimate.derive("J/mc")
            values = [_value(estimate, parameter) for parameter in ("J", "mc", "Fv", "Fc")]
            curved = " (curved)" if caught else ""  # the delta method says that it is not enough
            quotient = f"{ratio.value:.3f} +- {ratio.sd_hac:.3f}{curved}"
            counted = [f"{cutoff:g}", f"{len(estimate.residuals)}"]
            error = f"{estimate.equation_error_percent:.1f}"
            rows.append([name, *counted, *values, quotient, error])
    return rows


def weight_table(data: Data, cutoff: float = SHOWN, force: float = 5.0) -> Rows:
    """What one sample of the torque weighs: the estimates' change for so many N m on it."""
    settings = prefilter(data.run, cutoff)
    ends = SampledFilter(settings, data.run.period).dropped
    named, count = replace(settings, drop=ends), len(data.run)
    last = count - 1 - ends[1]
    cases = [("last of the record", settings, count - 1), ("last kept", settings, last)]
    cases += [
        ("heaviest", settings, heaviest(data.run, settings)),
        ("last kept, ends named", named, last),
    ]
    rows = []
    for name, chosen, place in cases:
        torque = np.array(data.run.control)
        torque[place] += force
        row = [name]
        for method in ("idm-ls", "idm-iv"):
            before, after = (
                identify(axis, record, chosen, [method], judge=False)[method].physical
                for record in (data.run, replace(data.run, control=torque))
            )
            row += [f"{change:.3f}" for change in (after - before)[[0, 1, 3]]]
        rows.append(row)
    return rows


def heaviest(run: Record, settings: Prefilter) -> int:
    """The torque sample that moves mc by IDM-IV most, for the instruments as they are."""
    estimate = identify(axis, run, settings, ["idm-iv"], judge=False)["idm-iv"]
    instruments = np.asarray(estimate.Z)
    by_row = np.linalg.solve(instruments.T @ estimate.X, instruments.T)
    by_sample = by_row @ SampledFilter(settings, run.period).reduce(np.eye(len(run)))
    return int(np.abs(by_sample[1]).argmax())


def weak_table(data: Data) -> Rows:
    """The same without derivatives and without axisid."""
    found = {name: weak_form(record) for name, record in data.records.items()}
    return [
        [name, f"{theta[0]:.3f}", f"{theta[1]:.3f}", f"{theta[0] / theta[1]:.3f}", f"{error:.1f}"]
        for name, (theta, error) in found.items()
    ]


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
            table(
                "Sweep", f"Hz | rows | {estimates} | weakest F | p of LS = IV", sweep_table(results)
            ),
            f"control law: {check_of(shown(results), 'control law').meaning}\n",
            table("Gains", f"p / d | {both} | weakest F | off [mrad]", gains_table(data)),
            table(
                "Stretch kept",
                "left out at start / end | rows | J | 95 % | mc | 95 %",
                stretch_table(data),
            ),
            table("Timing", f"record | Hz | {best}", delay_table(data)),
            table("Timing of twins", "Hz | best [ms] | each", twin_delay_table(twins)),
            table(
                "Motions",
                f"motion | Hz | rows | {both} | Fv | Fc | J/mc [m] | error [%]",
                motions_table(data),
            ),
            table("Weak form", f"motion | {both} | J/mc [m] | error [%]", weak_table(data)),
            table("Validation", f"estimate | {' | '.join(MOTIONS)}", validation_table(data)),
            table(
                "Twins",
                "added | recipe, J / mc | IDM-LS | IDM-IV | IDM-IV converged | "
                "mc holds truth / published",
                twin_table(data, truth),
            ),
            table(
                "Weight of one torque sample",
                "5 N m on | LS J | LS mc | LS Fc | IV J | IV mc | IV Fc",
                weight_table(data),
            ),
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
