"""What limits an open loop of the EMPS: how a force drifts, and what two numbers of a cycle buy."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from emps_ladder_data import Data, Model, cycle, left
from emps_ladder_models import GAIN, rescaled

from axisid import Prefilter, build, fit, identify
from axisid.estimation import validate_fit

PUSH = 0.05  # N
#: Fitted cycles, the cycle that two numbers are from, the one that is scored.
ORDERS = (((0, 1), 2, 3), ((2, 3), 1, 0))


def drifts(data: Data, model: Model, values: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """What 1 N that is not there leaves, m, by length of the windows: as an offset, as friction.

    First positions and velocities are fitted as they always are, and take their part of it.
    """
    record = data.record(model)
    direction = np.sign(np.gradient(record.position))
    found = {}
    for name, horizon in (("1 s", 1.0), ("5 s", 5.0), ("half", 12.4), ("whole", 24.84)):
        before = left(model, record, values, horizon)
        found[name] = {}
        for kind, shape in (("offset", np.ones(len(record))), ("friction", direction)):
            pushed = replace(record, control=np.asarray(record.control) + PUSH / GAIN * shape)
            moved = left(model, pushed, values, horizon) - before
            found[name][kind] = float(np.sqrt(np.mean(moved**2))) / PUSH
    return found


def two_numbers(
    data: Data, model: Model, horizon: float, starts: Sequence[Mapping[str, float]]
) -> dict[str, list[float]]:
    """What a model leaves of a cycle, m, with none, one and two numbers from the cycle next to it.

    All other parameters are from two cycles that are neither, by a fit from `starts`. The last
    entry has the two numbers of the very cycle that is scored.
    """
    found: dict[str, list[float]] = {"none": [], "offset": [], "both": [], "of itself": []}
    for (fitted, near, held), start in zip(ORDERS, starts, strict=True):
        known = [cycle(k) for k in fitted]
        result = fit(
            model.axis, data.record(model, known), "open-loop", horizon=horizon, start=start
        )
        values = dict(zip(result.names, map(float, result.physical), strict=True))
        axis = build(rescaled(model.terms, values))
        scored = data.read(axis, [cycle(held)])
        begin = {"scale": 1.0, "tau0": values["tau0"]}
        found["none"].append(validate_fit(result, data.record(model, [cycle(held)])).error)
        for name, k, fixed in (
            ("offset", near, {"scale": 1.0}),
            ("both", near, {}),
            ("of itself", held, {}),
        ):
            own = data.read(axis, [cycle(k)])
            two = fit(axis, own, "open-loop", horizon=horizon, start=begin, fixed=fixed)
            found[name].append(validate_fit(two, scored).error)
    return found


def ends(data: Data, model: Model, horizon: float, start: Mapping[str, float]) -> list[float]:
    """What searches from eight starts leave of the whole record, m, the least first."""
    found = fit(model.axis, data.record(model), "open-loop", horizon=horizon, start=start, starts=8)
    least = min(cost for cost, _ in found.ends)
    return sorted(found.error * float(np.sqrt(cost / least)) for cost, _ in found.ends)


def offsets(data: Data, model: Model, cutoff: float = 60.0) -> dict[str, tuple[float, float]]:
    """Offset and Coulomb friction of each cycle, by least squares with all else in common."""
    cycles = [data.record(model, [cycle(k)]) for k in range(4)]
    settings = Prefilter(cutoff=cutoff)
    result = identify(model.axis, cycles, settings, ["idm-ls"], local=("tau0", "Fc"), judge=False)
    found = result["idm-ls"].parameters
    return {n: (v.value, v.deviation) for n, v in found.items() if n[:-2] in ("tau0", "Fc")}
