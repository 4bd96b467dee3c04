"""How fast everything is: ratios to yardsticks, and to another commit, measured in one run.

A figure is CPU time of the fastest run, but of a long log, which is run once; of memory the
greatest. The yardsticks are hand-written C of the same loop (`hand_written.c`: one simulation, and
one of 32 side by side in registers), the parts that no fit of instruments can avoid, and an
interpreter that imports NumPy. With another commit both are measured in turn, figure by figure and
round by round, by the same calls: the median ratio stands before the lowest and the highest of the
rounds, and is marked where all rounds are on one side of 1.

    python benchmarks/speed.py                    a table of this checkout
    python benchmarks/speed.py --against HEAD~1   beside another commit
    python benchmarks/speed.py --only fit         the figures with a word in their name
    python benchmarks/speed.py --json -           one JSON object
"""

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path
from statistics import median
from typing import Any

from figures import give, parser_of

ROOT = Path(__file__).resolve().parents[1]
UNITS = {"ms": 1e3, "us": 1e6, "kB": 1e-3}
CODE = ("src", "modeling", "codegen", "estimation", "generated")  # folders of a checkout
#: Threads that wait for one another take CPU time too, the more the busier the machine is.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

LOOP, REGISTERS, FLOOR, NUMPY = "C by hand", "C by hand, in registers", "floor", "import numpy"
RESULT = "result.json"
IDENTIFY = ("-m", "axisid", "identify", "emps2015", "--json", RESULT)
LOAD = f"import axisid; axisid.load_result({RESULT!r})"
EXPORT = ("-m", "axisid", "export", RESULT, "--axis", "emps2015", "--to", "c")
GENERATE = """
import os, tempfile
os.environ["AXISID_CACHE"] = tempfile.mkdtemp(dir=".")
from axisid import derive, load_axis
from axisid.codegen.generated_axes.texts import axis_artefacts
from axisid.codegen.generated_axes.texts import FUNCTIONS, NATIVE
from axisid.codegen.runtime import Native, execute
texts = axis_artefacts(derive(load_axis("valve")))
assert Native(texts[NATIVE], execute(texts[FUNCTIONS], "valve")).library()
"""


@dataclass(frozen=True)
class Figure:
    """What is measured: by `timed_runs.py`, or the arguments of an interpreter of its own."""

    name: str
    over: str | None = None
    unit: str = "ms"
    arguments: tuple[str, ...] = ()


#: Each group has a process of its own, since the greatest memory is that of a process.
GROUPS = (
    (
        Figure(LOOP),
        Figure("simulate", LOOP),
        Figure("simulate, new parameters", LOOP),
        Figure(REGISTERS),
        Figure("simulate_batch", REGISTERS),
        Figure(FLOOR),
        Figure("identify", FLOOR),
        Figure("identify, intervals", FLOOR),
        Figure("identify, default methods, judged", FLOOR),
        Figure("Monte-Carlo run, published filter", LOOP),
        Figure("Monte-Carlo run, default filter", LOOP),
        Figure("fit", LOOP),
        Figure("fit, judged", LOOP),
        Figure(NUMPY, arguments=("-c", "import numpy")),
        Figure("import axisid", NUMPY, arguments=("-c", "import axisid")),
        Figure("import of identify", NUMPY, arguments=("-c", "from axisid import identify")),
        Figure("--help", NUMPY, arguments=("-m", "axisid", "--help")),
        Figure("show", NUMPY, arguments=("-m", "axisid", "show", "emps")),
        Figure("load_result", NUMPY, arguments=("-c", LOAD)),
        Figure("export", NUMPY, arguments=EXPORT),
        Figure("generate, cold", NUMPY, arguments=("-c", GENERATE)),
    ),
    (Figure("long log, a sample", unit="us"), Figure("peak memory, a sample", unit="kB")),
)

Costs = Mapping[str, Sequence[Sequence[float]]]  # by figure, checkout and round


class Checkout:
    """Code that is measured; `scratch` is a folder for what it writes."""

    def __init__(self, root: Path, scratch: Path) -> None:
        places = {"AXISID_CACHE": str(scratch / "cache"), "PYTHONPATH": str(root / "src")}
        self.env, self.scratch = os.environ | ONE_THREAD | places, scratch
        scratch.mkdir()
        subprocess.run([sys.executable, "-m", "compileall", "-q", *CODE], cwd=root, check=False)
        self.run(IDENTIFY)

    def run(self, arguments: Sequence[str]) -> float:
        """CPU seconds of an interpreter and what it starts; not a number where it fails."""
        begin = children_seconds()
        command, silent = [sys.executable, *arguments], subprocess.DEVNULL
        done = subprocess.run(command, env=self.env, cwd=self.scratch, check=False, stdout=silent)
        return nan if done.returncode else children_seconds() - begin

    def worker(self) -> subprocess.Popen[str]:
        """A process that answers what its runs cost, once it is ready; it ends with its input."""
        command = [sys.executable, str(Path(__file__).with_name("timed_runs.py"))]
        pipe = subprocess.PIPE
        started = subprocess.Popen(command, env=self.env, text=True, stdin=pipe, stdout=pipe)
        assert started.stdout is not None
        started.stdout.readline()  # its imports shall not take from what is measured meanwhile
        return started

    def cost(self, figure: Figure, worker: subprocess.Popen[str]) -> float:
        """CPU seconds or bytes; not a number where this code cannot run it."""
        if figure.arguments:
            return self.run(figure.arguments)
        print(figure.name, file=worker.stdin, flush=True)
        return float(worker.stdout.readline())


def children_seconds() -> float:
    """CPU seconds of all processes that have ended."""
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def measured(
    checkouts: Sequence[Checkout], groups: Sequence[Sequence[Figure]], rounds: int
) -> Costs:
    """Costs of the figures, the checkouts in turn; who is first changes from round to round."""
    costs = {f.name: [[nan] * rounds for _ in checkouts] for group in groups for f in group}
    for turn in range(rounds):
        for group in groups:
            with ExitStack() as stack:
                both = [(c, stack.enter_context(c.worker())) for c in checkouts]
                order = [*enumerate(both)][:: -1 if turn % 2 else 1]
                for figure in group:
                    for number, (checkout, worker) in order:
                        costs[figure.name][number][turn] = checkout.cost(figure, worker)
                    if isnan(costs[figure.name][0][turn]):
                        raise SystemExit(f"this checkout fails at: {figure.name}")
    return costs


def spread(above: Sequence[float], below: Sequence[float]) -> dict[str, float]:
    """Median, lowest and highest ratio of the rounds."""
    ratios = [a / b for a, b in zip(above, below, strict=True)]
    return {"ratio": median(ratios), "lowest": min(ratios), "highest": max(ratios)}


def row(figure: Figure, costs: Costs) -> dict[str, Any]:
    """A figure's cost, its ratio to the yardstick and to the other commit where it runs there."""
    here, *there = costs[figure.name]
    found: dict[str, Any] = {"cost": UNITS[figure.unit] * median(here), "unit": figure.unit}
    if figure.over:
        found |= {"yardstick": figure.over, "over": spread(here, costs[figure.over][0])}
    if there and not isnan(there[0][0]):
        found["against"] = spread(here, there[0])
    return found


def lines(rows: Mapping[str, Mapping[str, Any]], rounds: int) -> Iterator[str]:
    """The table as text."""
    for name, of in rows.items():
        text = f"{name:<34}{of['cost']:>10.4g} {of['unit']}  "
        text += f"{of['over']['ratio']:8.4g} x {of['yardstick']:<24}" if "over" in of else " " * 35
        if beside := of.get("against"):
            text += "{ratio:.3f} ({lowest:.3f} to {highest:.3f})".format(**beside)
            text += " slower" * (beside["lowest"] > 1) + " faster" * (beside["highest"] < 1)
        yield text.rstrip()
    if any("against" in of for of in rows.values()):
        yield f"slower, faster: in all rounds, as {2.0 ** (1 - rounds):.2g} are by chance alone"


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--against", metavar="REV", help="a commit to measure beside this checkout")
    parser.add_argument("--only", metavar="WORD", default="", help="figures with it in their name")
    parser.add_argument("--rounds", type=int, default=5, help="of everything (default 5)")
    given = parser.parse_args()
    wanted = [(f.name, f.over) for group in GROUPS for f in group if given.only in f.name]
    if not wanted:
        parser.error(f"no figure has {given.only!r} in its name")
    groups = [[f for f in group if any(f.name in names for names in wanted)] for group in GROUPS]
    with tempfile.TemporaryDirectory() as place:
        checkouts = [Checkout(ROOT, Path(place, "here"))]
        if given.against:
            packed, other = Path(place, "commit.tar"), Path(place, "commit")
            command = [shutil.which("git") or "git", "archive", "-o", packed, given.against]
            if subprocess.run(command, cwd=ROOT, check=False).returncode:
                parser.error(f"git has no commit {given.against} here: give one, such as HEAD~1")
            shutil.unpack_archive(packed, other, filter="data")
            checkouts.append(Checkout(other, Path(place, "there")))
        costs = measured(checkouts, [*filter(None, groups)], given.rounds)
    rows = {f.name: row(f, costs) for group in groups for f in group}
    give(rows, given.json, lines(rows, given.rounds))


if __name__ == "__main__":
    main()
