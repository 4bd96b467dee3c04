"""Motors on a voltage and behind a gear: the loop and its parameters, against an integrator apart.

A joint with a weight moves under each drive of `axisid.elements`: a voltage with a back-EMF that is
known or identified, with an inductance, a gear that takes its share by the direction of the power,
a current as far as the supply reaches. The records are made by an integrator that shares nothing
with the program: the winding's current is a state of its own, in steps of a fiftieth of a sample.
Told are how far the simulated loop is from it, how many of the parameters' 95 % intervals hold the
truth, and how far the parameters are off where the drive is declared as a gain alone.

    python benchmarks/voltage_drives.py              a table
    python benchmarks/voltage_drives.py --json -     one JSON object
"""

from dataclasses import replace

import numpy as np
from figures import give, parser_of
from motor_joint import (
    KE_TRUTH,
    LIMIT,
    MOTOR,
    NOISE,
    OHMS,
    PERIOD,
    ROTOR,
    Motor,
    integrated,
    joint,
    on_voltage,
)

from axisid import Record, build, identify, simulate, twin_record
from axisid.elements import Drive, current_drive, voltage_drive

#: By name what a record is made with, and the drive that says so.
CASES: dict[str, tuple[Motor, Drive]] = {
    "voltage": (Motor(), on_voltage()),
    "voltage, ke identified": (
        Motor(ke=KE_TRUTH),
        voltage_drive(resistance=OHMS, **MOTOR),
    ),
    "L/R a tenth of the period": (Motor(lag=1e-4), on_voltage(inductance=1e-4 * OHMS)),
    "L/R half the period": (Motor(lag=5e-4), on_voltage(inductance=5e-4 * OHMS)),
    "L/R two periods": (Motor(lag=2e-3), on_voltage(inductance=2e-3 * OHMS)),
    "gear of 70 %": (Motor(efficiency=0.7), on_voltage(efficiency=0.7)),
    "gear of 70 %, rotor before it": (
        Motor(efficiency=0.7, rotor=ROTOR),
        on_voltage(efficiency=0.7),
    ),
    "current up to the supply": (
        Motor(supply=6.0),
        current_drive(**MOTOR, supply=6.0, resistance=OHMS),
    ),
}


def record_of(motor: Motor, like: Record, seed: int) -> Record:
    """A record that the integrator makes, of the reference of another."""
    noise = np.random.default_rng(seed).normal(0.0, NOISE, len(like))
    made = integrated(motor, np.asarray(like.reference), noise)
    return replace(like, position=made["position"] + noise, control=made["control"])


def figures_of(name: str, runs: int) -> dict[str, float]:
    """Of one case: the simulated loop's distance, coverage, and what a gain alone makes of it."""
    motor, drive = CASES[name]
    declared = joint(drive, emf=name.endswith("identified"))
    axis, truth = build(declared), declared.experiment.truth
    like = twin_record(axis, seed=1)
    reference = np.asarray(like.reference)
    still = integrated(motor, reference, np.zeros(len(like)))
    loop = simulate(axis, [truth[p.name] for p in declared.parameters], reference, PERIOD)
    plain = build(replace(declared, drive=Drive(gain=drive.gain, unit=drive.unit, limit=LIMIT)))
    held, counted, off, wrong = 0, 0, [], []
    for seed in range(1, runs + 1):
        record = record_of(motor, like, seed)
        found = identify(axis, record, methods=["idm-iv"], judge=False)["idm-iv"].parameters
        alone = identify(plain, record, methods=["idm-ls"], judge=False)["idm-ls"].parameters
        for key, value in found.items():
            half = (value.interval[1] - value.interval[0]) / 2
            held += abs(value.corrected - truth[key]) <= half
            counted += 1
        off.append([value.corrected / truth[key] - 1 for key, value in found.items()])
        wrong.append([value.value / truth[key] - 1 for key, value in alone.items()])
    names = list(found)
    return {
        "loop, relative": float(np.max(np.abs(loop.position - still["position"])))
        / float(np.ptp(reference)),
        "inside": held / counted,
        **{f"{n} off, %": 100 * x for n, x in zip(names, np.mean(off, axis=0), strict=True)},
        **{
            f"{n} off by a gain alone, %": 100 * x
            for n, x in zip(names, np.mean(wrong, axis=0), strict=True)
        },
    }


def main() -> None:
    """Print the figures."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--only", default="", help="cases whose name has this in it")
    options = parser.parse_args()
    found = {name: figures_of(name, options.runs) for name in CASES if options.only in name}
    lines = [
        line
        for name, values in found.items()
        for line in (name, *(f"  {key:<32}{value:.3g}" for key, value in values.items()))
    ]
    give({"runs": options.runs, **found}, options.json, lines)


if __name__ == "__main__":
    main()
