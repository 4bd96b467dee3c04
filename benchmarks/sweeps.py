"""What `sweep` recommends, against the best of its cut-offs.

Machines with noises of several kinds (`machines`, a simulator of its own) and the library's twins,
as they are, their references left out, also without their control laws, and logs that are thinned
to 100 and 250 Hz. For each recommended cut-off: the largest error of a parameter there in percent
of its value, the least that any cut-off of the sweep has and what the lowest one has, and which
share of the intervals there hold the truth.

    python benchmarks/sweeps.py                     a table
    python benchmarks/sweeps.py --json -            one JSON object
    python benchmarks/sweeps.py --only "pendulum, no law"
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from field import FIXED
from figures import give, parser_of

from axisid import (
    AxisidError,
    Coordinate,
    Parameter,
    Record,
    build,
    load_axis,
    newton,
    simulate,
    sweep,
    twin_record,
)
from axisid.codegen.generated_axes import GeneratedAxis
from axisid.control import cascade_pd
from axisid.elements import Drive, coulomb, viscous
from axisid.estimation.estimates import Estimate
from axisid.modeling import LIBRARY

_MACHINES = (
    "PD, 2 um, dwells, force of 20 ms",
    "PD, white position noise of 5 um, dwells",
    "PID, 20 um, joystick",
    "P-PI, 10 um, rounded currents, multisine",
)


def _without_law(axis: GeneratedAxis) -> GeneratedAxis:
    return build(replace(axis.axis, control=None))


def table_axis() -> GeneratedAxis:
    """A rotary axis with much friction, J = 0.4."""
    q = Coordinate("q", unit="rad")
    inertia = Parameter("J", "kg m^2", nominal=0.4, lower=0.0)
    fv, fc = Parameter("fv", "N m/(rad/s)"), Parameter("fc", "N m")
    return build(
        newton(
            "table",
            coordinate=q,
            parameters=(inertia, fv, fc),
            inertia=inertia,
            resistance=(viscous(fv, q), coulomb(fc, q)),
            drive=Drive(gain=1.0, unit="A"),
            control=cascade_pd(kp=12.0, kv=25.0, period=1e-3),
        )
    )


def thinned(rate: float, noise: float, seed: int) -> tuple[GeneratedAxis, Record]:
    """A log of that axis, thinned to a rate in Hz, with noise of the position in rad."""
    axis, truth = table_axis(), {"J": 0.4, "fv": 0.8, "fc": 2.0}
    time = 1e-3 * np.arange(30000)
    rng = np.random.default_rng(seed)
    begin = np.minimum(1.0, time / 0.5)
    waves = ((0.6, 0.4), (0.2, 1.1), (0.05, 2.7))
    phases = rng.uniform(0, 2 * math.pi, len(waves))
    reference = begin * sum(
        a * np.sin(2 * math.pi * f * time + p) for (a, f), p in zip(waves, phases, strict=True)
    )
    loop = simulate(axis, [*truth.values()], reference, 1e-3)
    step = round(1000 / rate)
    position = loop.position[::step] + rng.normal(0.0, noise, len(time[::step]))
    origin = twin_record(build(load_axis("emps2015"))).provenance
    record = Record(
        time=time[::step],
        position=position,
        control=loop.control[::step],
        provenance=replace(origin, source=f"{rate:g} Hz", truth=truth),
    )
    return _without_law(axis), record


def cases(seed: int) -> Iterator[tuple[str, GeneratedAxis, Record, dict[str, float]]]:
    """Every case with its truth."""
    for name in LIBRARY:
        axis = build(load_axis(name))
        whole = twin_record(axis, seed=seed)
        twin, truth = replace(whole, reference=None), dict(whole.provenance.truth)
        yield f"{name}, as it is", axis, whole, truth
        yield f"{name}, no reference", axis, twin, truth
        yield f"{name}, no law", _without_law(axis), twin, truth
    for name in _MACHINES:
        case = FIXED[name]
        axis, truth = case.axis, case.truth
        whole = next(case.records(1, seed))
        record = replace(whole, reference=None)
        yield f"{name}, as it is", axis, whole, truth
        yield f"{name}, no reference", axis, record, truth
        yield f"{name}, no law", _without_law(axis), record, truth
    for rate, noise in ((100.0, 1e-4), (250.0, 1e-5), (250.0, 1e-4), (1000.0, 3e-5)):
        axis, record = thinned(rate, noise, seed)
        truth = dict(record.provenance.truth)
        yield f"{rate:g} Hz, noise of {noise:g} rad, no law", axis, record, truth


def off(estimate: Estimate, truth: dict[str, float]) -> float:
    """Largest error of a parameter that is not about zero, percent of its value."""
    errors = (
        abs(value.corrected / truth[name] - 1)
        for name, value in estimate.parameters.items()
        if truth.get(name)
    )
    return 100 * max(errors)


def judged(axis: GeneratedAxis, record: Record, truth: dict[str, float]) -> dict[str, object]:
    """What the recommended cut-off is worth."""
    found = sweep(axis, record)
    every = {result.prefilter.cutoff: result.preferred for result in found.results}
    said: dict[str, object] = {
        "least": min(off(e, truth) for e in every.values()),
        "lowest": off(next(iter(every.values())), truth),
        "recommended": found.recommended,
    }
    if found.recommended is None:
        return said
    chosen = every[found.recommended]
    values = chosen.parameters.items()
    held = [v.interval[0] <= truth[n] <= v.interval[1] for n, v in values if n in truth]
    return said | {"off": off(chosen, truth), "held": sum(held) / len(held)}


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=1, help="seeds of each case (default 1)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", metavar="NAME", help="cases of which this is a part")
    options = parser.parse_args()
    found: dict[str, list[dict[str, object]]] = {}
    for seed in range(options.seed, options.seed + options.runs):
        for name, axis, record, truth in cases(seed):
            if options.only is None or options.only in name:
                try:
                    said = judged(axis, record, truth)
                except AxisidError as error:
                    said = {"refused": str(error)}
                found.setdefault(name, []).append(said)
                if options.json is None:
                    print(_line(name, said), flush=True)
    give(found, options.json, ())


def _line(name: str, said: dict[str, object]) -> str:
    figures = (f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in said.items())
    return f"{name:<40}{'  '.join(figures)}"


if __name__ == "__main__":
    main()
