"""Twins of the DFKI pendulum's run, whose parameters and delay are known; delays of the torque.

`dfki_pendulum_study.py` uses them.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from dfki_pendulum import axis
from dfki_pendulum_data import (
    PUBLISHED,
    SHOWN,
    Array,
    Data,
    Rows,
    authors_recipe,
    derivative,
    high_pass,
    prefilter,
)
from scipy import ndimage, signal

from axisid import Record, identify, simulate

DELAYS = np.arange(-12.0, 36.1, 2.0) * 1e-3  # s


def delayed(record: Record, samples: float) -> Record:
    """The record with its torque taken so many samples earlier.

    By a cubic spline: straight lines would smooth the spikes between two samples.
    """
    moved = ndimage.shift(np.asarray(record.control), samples, order=3, mode="nearest")
    return replace(record, control=moved)


def delay_profile(record: Record, cutoff: float, delays: Array) -> tuple[Array, Array]:
    """Equation error in percent and estimate of least squares over the delay, in s."""
    settings = prefilter(record, cutoff)
    record = replace(record, reference=None)  # no simulation is needed
    estimates = [
        identify(axis, delayed(record, d / record.period), settings, ["idm-ls"], judge=False)[
            "idm-ls"
        ]
        for d in delays
    ]
    return (
        np.array([e.equation_error_percent for e in estimates]),
        np.array([e.physical for e in estimates]),
    )


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
    """What each estimator makes of twins: mean and spread over a hundred shuffles.

    The last column counts the 95 % intervals of mc by IDM-IV that hold the truth, and those that
    hold the published value.
    """
    rows = []
    for shaken, spiked in ((False, False), (True, False), (False, True), (True, True)):
        found: dict[str, list[Array]] = {}
        held = np.zeros(2, dtype=int)
        for seed in range(100 if spiked else 1):
            one = twin(data, truth, seed, shaken=shaken, spiked=spiked)
            theta, _ = authors_recipe(one.run, one.velocity["identification run"])
            found.setdefault("recipe", []).append(theta)
            # Instruments that do not converge leave their method out of the result.
            estimates = identify(axis, one.run, prefilter(one.run, SHOWN), judge=False).estimates
            for method in ("idm-ls", "idm-iv"):
                if method in estimates:
                    found.setdefault(method, []).append(estimates[method].physical)
            if "idm-iv" in estimates:
                low, high = estimates["idm-iv"].parameters["mc"].interval
                held += [low < value < high for value in (truth[1], PUBLISHED[1])]
        added = " and ".join(["shaking"] * shaken + ["spikes"] * spiked) or "nothing"
        cells = [np.array(found[method]) for method in ("recipe", "idm-ls", "idm-iv")]
        values = [f"{_spread(c[:, 0])} / {_spread(c[:, 1])}" for c in cells]
        converged = f"{len(cells[2])} of {len(cells[0])}"
        rows.append([added, *values, converged, f"{held[0]} / {held[1]}"])
    return rows


def _spread(values: Array) -> str:
    return f"{values.mean():.3f}" + (f" +- {values.std():.3f}" if len(values) > 1 else "")
