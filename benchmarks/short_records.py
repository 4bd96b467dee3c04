"""What becomes of records of one stroke or two, which have fewer than 80 rows in motion.

Machines and faults are those of `field`, simulated apart from the program, in records that are so
short. Of each right machine there is one record, and of each fault one in each of two axes. The
tables are those of `verdicts.py`.

    python benchmarks/short_records.py                      identified, and fitted by the control
    python benchmarks/short_records.py --seed 7             other machines, other noise
    python benchmarks/short_records.py --by position        fitted by the position alone
"""

from dataclasses import replace
from functools import cache, partial
from zlib import crc32

import numpy as np
from field import FAULTS, Case, axes_of_faults, drawn
from figures import parser_of
from verdicts import Run, run_of, tell

from axisid import Prefilter

#: Rows of a record, of which those in motion are fewer.
_ROWS = 45, 75
_RIGHT = 16
_FAULTS = (
    "Stribeck",
    "quadratic",
    "spring",
    "offset",
    "saturates",
    "feed-forward out of the log",
    "kp 10 % larger",
    "damping 10 % larger",
)


def short(case: Case, rows: int) -> Case:
    """A case whose record has so many rows before any is left out."""
    period = case.machine.period
    seconds = rows * Prefilter().at_rate_of(period).decimate * period
    # There and back within it, from and to rest where the motion has rests.
    rise = max(min(case.motion.rise, seconds / 14), 10 * period)
    speed = case.motion.speed * rise / case.motion.rise  # as much force
    return replace(case, motion=case.motion._replace(seconds=seconds, rise=rise, speed=speed))


@cache
def short_cases(seed: int) -> dict[str, Case]:
    """The right ones and the wrong ones by name."""
    rng = np.random.default_rng([seed, 80])

    def cut(case: Case) -> Case:
        return short(case, int(rng.integers(*_ROWS)))

    found = {name: cut(case) for name, case in drawn(seed, _RIGHT).items()}
    axes = {name: cut(case) for name, case in axes_of_faults(seed).items() if name != "stage"}
    for fault in _FAULTS:
        change, named = FAULTS[fault]
        for name, case in axes.items():
            found[f"{fault}; {name}"] = replace(change(case), fault=fault, named=named)
    return found


def runs_of(name: str, *, seed: int, by: tuple[str, ...]) -> dict[str, list[Run]]:
    """What each estimator makes of the record of a case."""
    case = short_cases(seed)[name]
    (record,) = case.records(1, crc32(f"{seed} {name}".encode()))
    return {each: [run_of(case.axis, record, each, case.truth)] for each in by}


def main() -> None:
    """Print the tables, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--by", default="identify,control", help="estimators, by commas")
    parser.add_argument("--only", metavar="WORD", default="", help="cases whose name holds it")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    names = [name for name in short_cases(options.seed) if options.only in name]
    work = partial(runs_of, seed=options.seed, by=tuple(options.by.split(",")))
    tell(work, names, short_cases(options.seed), options)


if __name__ == "__main__":
    main()
