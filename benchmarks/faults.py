"""What becomes of faults in a log: whether a wrong number ever comes out with nothing said.

Right logs of twins, of the library and drawn at random, each with one random fault of its signals,
are read and identified with nothing asked for. Each run is ``refused`` with a sentence, ``told`` (a
check of the verdict fails, or a warning), ``harmless`` (every parameter is within three deviations
or 2 % of the truth), or ``SILENT``: wrong, and nothing said. ``broken`` is any other error than a
sentence, ``hung`` is more than 50 times the work of the same logs without a fault, and 10 s. The
control group, these logs, counts false alarms; faults are put into those logs that raise none.

    python benchmarks/faults.py               a table, and every run that is silent
    python benchmarks/faults.py --json -      one JSON object
    python benchmarks/faults.py --only 12     the runs of one axis
"""

import tempfile
import time
import traceback
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from figures import give, parser_of
from library import prefilter_of
from random_axes import random_axis
from signal_faults import FAULTS, Log, right_log, with_rests
from time_limit import WORK, Hung, in_time

from axisid import AxisidError, Identification, build, identify, load_axis, read_record, twin_record
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.modeling import LIBRARY

OUTCOMES = ("refused", "told", "harmless", "SILENT", "broken", "hung")
VARIANTS = ("full", "with force", "without reference", "force alone")
KINDS = (*FAULTS, "rests")

_RUNS_EACH = 20  # of one axis
_MOST_AXES = 10  # for each faulty log that is asked for
_LIBRARY = 0.15  # share of the axes
_LEAST_SECONDS, _MOST_SECONDS, _TIMES = 10.0, 600.0, 50.0  # of work
_DEVIATIONS, _PERCENT = 3.0, 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One run.

    Attributes
    ----------
    axis, run : int
        They draw the same again, with the seed.
    kind : str
        Of the fault; ``none`` in the control group.
    fault : str
        What was done to the log.
    outcome : str
        Of `OUTCOMES`; ``clean`` or ``alarm`` in the control group.
    said : str
        The sentence, the checks that fail, or what is wrong.
    """

    axis: int
    run: int
    kind: str
    fault: str
    outcome: str
    said: str


def draw_axis(seed: int, number: int) -> GeneratedAxis:
    """The axis of a number: of the library, or drawn."""
    rng = np.random.default_rng([seed, number])
    if rng.random() < _LIBRARY:
        return build(load_axis(str(rng.choice(LIBRARY))))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "drawn.toml")
        file.write_text(random_axis(rng).toml, encoding="utf-8")
        return build(load_axis(file))


def runs_of(number: int, *, seed: int, each: int) -> list[Run]:
    """Control runs of one axis, and its runs with faults in the logs that raise no alarm."""
    axis = draw_axis(seed, number)
    record = twin_record(axis)
    truth = record.provenance.truth
    columns = {role: np.array(values) for role, values in record.channels().items()}
    done, clean, most = [], [], 0.0
    for variant in VARIANTS:
        if "force" in variant and axis.axis.drive.profile != 1:
            continue  # the nominal force is the control's alone
        log = right_log(axis, columns, variant)
        begin = time.process_time()
        ended, said = identified(log, truth, _MOST_SECONDS)
        most = max(most, time.process_time() - begin)
        outcome = "clean" if ended == "harmless" else "alarm"
        clean += [log] if outcome == "clean" else []
        fault = f"{axis.axis.name} ({variant})"
        done.append(Run(axis=number, run=-1, kind="none", fault=fault, outcome=outcome, said=said))
    for run in range(each if clean else 0):
        rng = np.random.default_rng([seed, number, run])
        kind = KINDS[(number * each + run) % len(KINDS)]
        faulty = faulty_log(axis, clean, kind, rng)
        if faulty is not None:
            seconds = min(max(_LEAST_SECONDS, _TIMES * most), _MOST_SECONDS)
            ended, said = identified(faulty[0], truth, seconds)
            done.append(
                Run(axis=number, run=run, kind=kind, fault=faulty[1], outcome=ended, said=said)
            )
    return done


def faulty_log(
    axis: GeneratedAxis, clean: list[Log], kind: str, rng: np.random.Generator
) -> tuple[Log, str] | None:
    """A right log with a fault of a kind, and what was done; None where no log shows it."""
    if kind == "rests":
        return with_rests(axis, rng)
    for k in rng.permutation(len(clean)):
        faulty = FAULTS[kind](clean[k], rng)
        if faulty is not None:
            return faulty[0], f"{faulty[1]} ({', '.join(clean[k].signals)})"
    return None


def identified(log: Log, truth: dict[str, float], seconds: float) -> tuple[str, str]:
    """How an identification from a log ends, and what is said."""
    try:
        with in_time(seconds, WORK):
            axis = build(log.axis)
            # By role, whatever names of columns an axis of the library declares.
            record = read_record(log.columns, axis, columns={role: role for role in log.columns})
            result = identify(axis, record, prefilter_of(log.axis.name))
            said = doubts(result)
    except AxisidError as error:
        return "refused", str(error)
    except Hung as hung:
        return "hung", str(hung)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return "broken", f"{type(error).__name__}: {error} ({Path(place.filename).name})"
    if said:
        return "told", said
    wrong = off(result, truth)
    return ("SILENT", wrong) if wrong else ("harmless", "")


def doubts(result: Identification) -> str:
    """The checks that fail, the methods that came to nothing, and the warnings of the reader."""
    said = [check.name for check in result.verdict if check.status == "fail"]
    said += [f"{method} failed" for method in result.failed]
    provenance = result.record.provenance
    said += [note for note in provenance.assumed if not _is_usual(note)]
    said += map(str, provenance.doubts)
    return "; ".join(said)


def _is_usual(note: str) -> bool:
    """What is said of every log of arrays."""
    return note.startswith(("SI where the log has no unit", "no column"))


def off(result: Identification, truth: dict[str, float]) -> str:
    """Parameters whose truth is outside three deviations and 2 %."""
    wrong = []
    for name, value in result.preferred.parameters.items():
        apart = value.corrected - truth[name]
        if not abs(apart) <= max(_DEVIATIONS * value.deviation, _PERCENT / 100 * abs(truth[name])):
            percent = 100 * apart / truth[name] if truth[name] else float("inf")
            wrong.append(f"{name} {percent:+.3g} %, {apart / value.deviation:+.3g} deviations")
    return "; ".join(wrong)


def table(runs: list[Run]) -> str:
    """Runs by kind and outcome, and every run that is silent, broken or hung."""
    counted = Counter((run.kind, run.outcome) for run in runs)
    faulty = [run for run in runs if run.kind != "none"]
    alarms = [run for run in runs if run.outcome == "alarm"]
    control = sum(run.kind == "none" for run in runs)
    lines = [f"{'fault':<14}{'runs':>6}" + "".join(f"{outcome:>10}" for outcome in OUTCOMES)]
    for kind in (*KINDS, "all"):
        shares = [
            sum(n for (k, o), n in counted.items() if o == outcome and kind in (k, "all"))
            for outcome in OUTCOMES
        ]
        row = f"{kind:<14}{sum(shares):>6}" + "".join(f"{n or '-':>10}" for n in shares)
        lines += [row] if sum(shares) else []
    lines += ["", f"without a fault: {len(alarms)} of {control} logs raise an alarm"]
    names = Counter(name for run in alarms for name in run.said.split("; "))
    lines += [f"  {count} {name}" for name, count in names.most_common()]
    listed = [run for run in faulty if run.outcome in ("SILENT", "broken", "hung")]
    lines += [""] if listed else []
    lines += [f"{r.outcome} --only {r.axis}, {r.kind}, {r.fault}: {r.said}" for r in listed]
    return "\n".join(lines)


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=2000, help="faulty logs (default 2000)")
    parser.add_argument("--seed", type=int, default=1, help="of all draws (default 1)")
    parser.add_argument("--only", type=int, metavar="AXIS", help="the runs of one axis alone")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    options = parser.parse_args()
    runs = collected(options.runs, options.seed, options.only, options.jobs)
    figures = {
        "runs": sum(run.kind != "none" for run in runs),
        "seed": options.seed,
        "outcomes": dict(Counter(run.outcome for run in runs)),
        "each": [asdict(run) for run in runs],
    }
    give(figures, options.json, [table(runs)])


def collected(wanted: int, seed: int, only: int | None, jobs: int) -> list[Run]:
    """Runs of as many axes as give so many faulty logs."""
    of = partial(runs_of, seed=seed, each=min(_RUNS_EACH, wanted))
    if only is not None:
        return of(only)
    runs: list[Run] = []
    with ProcessPoolExecutor(jobs) as pool:
        number = 0
        while (missing := wanted - sum(run.kind != "none" for run in runs)) > 0:
            if number > _MOST_AXES * wanted:  # right logs of no axis are free of alarms
                break
            more = range(number, number + max(missing // _RUNS_EACH, 1))
            runs += [run for done in pool.map(of, more) for run in done]
            number = more.stop
    return runs


if __name__ == "__main__":
    main()
