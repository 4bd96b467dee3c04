"""Write what the program says now and print what moved: ``python -m tests.golden [CASE...]``.

Real records are looked for where tests do; what reads one stays as it is where that is absent.
"""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.golden.cases import CASES
from tests.golden.results import keep, kept_of, moves, result_of

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("AXISID_DATA", ROOT.parent / "shared" / "data"))


def main(names: list[str]) -> None:
    """Renew the results that are named, or all."""
    print(f"{'case':20} {'what':60} {'old':>16} {'new':>16}  deviations")
    for case in CASES:
        if names and case.name not in names:
            continue
        if case.record and not Path(case.record.format(data=DATA)).exists():
            print(f"{case.name:20} left as it is: there are no real records in {DATA}")
            continue
        with TemporaryDirectory() as folder:
            result = result_of(case, {"data": DATA, "root": ROOT, "folder": Path(folder)})
        moved = [*moves(kept_of(case), result)]
        for what, *values, by in moved:
            old, new = (each[0] if isinstance(each, list) else each for each in values)
            print(f"{case.name:20} {what:60} {old!s:>16} {new!s:>16}  {by}")
        if moved:
            keep(case, result)


if __name__ == "__main__":
    main(sys.argv[1:])
