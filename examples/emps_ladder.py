"""Which physical model of the EMPS leaves the least error in open loop, by held-out cycles.

Run it: python examples/emps_ladder.py DATA_EMPS.mat --output FOLDER

The axis gets the recorded control, and its position is compared with the recorded one: no control
law is simulated. It fits a ladder of models to windows of the public record, scores each on cycles
that its fit had no part in, and prints the tables of docs/emps_ladder.md; what they are made of
goes to FOLDER/emps_ladder.json, and what is there is not computed again. A window's first position
and velocity are fitted on that window itself, of every model alike.
"""

import argparse
import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from emps_ladder_data import (
    Data,
    Model,
    Split,
    Windows,
    halves,
    leave_one_out,
    nothing_held,
    read_data,
)
from emps_ladder_limits import PUSH, drifts, ends, offsets, two_numbers
from emps_ladder_tables import (
    LENGTHS,
    drifts_table,
    ladder_table,
    numbers_table,
    parameters_table,
    splits_table,
    table,
)

from axisid import AxisidError, Record, fit
from axisid.estimation import OutputFit, validate_fit

Start = Mapping[str, float] | str
Rung = tuple[Model, Model | None]  # a model, and the one that it starts from


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """What a model leaves, fitted to windows of one length.

    Attributes
    ----------
    fitted, held : list of float
        Root mean square on what was fitted and on what was held out, m, by split.
    values, deviations : list of dict of str to float
        Parameters by name, by split.
    """

    fitted: list[float]
    held: list[float]
    values: list[dict[str, float]]
    deviations: list[dict[str, float]]

    @property
    def error(self) -> float:
        """Of what was held out, over all splits; of what was fitted where nothing was."""
        return rms(self.held or self.fitted)


Scores = dict[str, Score]


def rms(values: Sequence[float]) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def lowest(record: Record, model: Model, horizon: float, starts: Sequence[Start]) -> OutputFit:
    """The lowest end of searches from several starts."""
    ends, why = list[OutputFit](), ""
    for start in starts:
        try:
            ends.append(fit(model.axis, record, "open-loop", horizon=horizon, start=start))
        except AxisidError as error:
            why = str(error)
    if not ends:
        raise SystemExit(f"{model.words}: {why}")
    return min(ends, key=lambda end: end.error)


def scored(
    data: Data,
    model: Model,
    horizon: float,
    splits: Sequence[Split],
    starts: Sequence[Sequence[Start]],
) -> Score:
    """Fit the parts of each split that are not held out, and score those that are."""
    found = Score(fitted=[], held=[], values=[], deviations=[])
    for split, begin in zip(splits, starts, strict=True):
        end = lowest(data.record(model, split.fitted), model, horizon, begin)
        found.fitted.append(end.error)
        found.values.append(dict(zip(end.names, map(float, end.physical), strict=True)))
        found.deviations.append({name: float(end[name].deviation) for name in end.names})
        if split.held:
            found.held.append(held_error(data, model, end, split.held, horizon))
    return found


def held_error(data: Data, model: Model, result: OutputFit, held: Windows, horizon: float) -> float:
    """Root mean square on parts that a fit is held against, m."""
    pieces = data.pieces(held, horizon)
    return rms([validate_fit(result, data.record(model, p), horizon=horizon).error for p in pieces])


def rung(data: Data, model: Model, below: Scores) -> Scores:
    """One model at every length of the windows; it starts where the rung below it ended."""

    def starts(name: str, before: Score | None = None) -> list[list[Start]]:
        ends: list[list[Start]] = [[] for _ in SPLITS[name]()]
        for source in filter(None, (before, below.get(name))):
            for k, each in enumerate(ends):
                each.append(source.values[k])
        return [each or ["nominal"] for each in ends]

    def at(name: str, begin: list[list[Start]]) -> Score:
        return scored(data, model, HORIZONS[name], SPLITS[name](), begin)

    found = {"1 s": at("1 s", starts("1 s"))}
    found["5 s"] = at("5 s", starts("5 s", found["1 s"]))
    found["half"] = at("half", starts("half"))
    two: list[Start] = [*found["half"].values]
    found["whole"] = at("whole", [two + starts("whole")[0]])
    return found


def aside(data: Data, model: Model, below: Scores) -> Scores:
    """One model at the shortest windows alone."""
    starts = [[values] for values in below["1 s"].values]
    return {"1 s": scored(data, model, HORIZONS["1 s"], leave_one_out(), starts)}


Step = Callable[[Data, Model, Scores], Scores]


def climbed(
    data: Data, file: Path, ladder: Sequence[Rung], step: Step, known: Mapping[str, Scores]
) -> dict[str, Scores]:
    """Every rung of a ladder, some of which start at known ones; what a file has is taken."""
    found = saved(file)
    for model, below in ladder:
        if model.words in found:
            continue
        begin = time.process_time()
        found[model.words] = step(data, model, {**known, **found}[below.words] if below else {})
        kept = {n: {h: asdict(s) for h, s in f.items()} for n, f in found.items()}
        file.write_text(json.dumps(kept))
        told = ", ".join(f"{n} {1e6 * s.error:.1f} um" for n, s in found[model.words].items())
        seconds = time.process_time() - begin
        print(f"{model.words}: {told}; {seconds:.0f} s of CPU", file=sys.stderr, flush=True)
    return found


def saved(file: Path) -> dict[str, Scores]:
    """What was found before."""
    if not file.is_file():
        return {}
    kept = json.loads(file.read_text())
    return {n: {h: Score(**s) for h, s in f.items()} for n, f in kept.items()}


#: Windows by what tables call them: their length, and what is held out.
HORIZONS = {"1 s": 1.0, "5 s": 5.0, "half": 24.84, "whole": 24.84}
SPLITS = {"1 s": leave_one_out, "5 s": leave_one_out, "half": halves, "whole": nothing_held}


_PUBLISHED, _DIRECTION = Model(), Model(terms=("direction",))


def _higher(model: Model, *terms: str) -> Model:
    return Model(terms=(*model.terms, *terms))


def _ladder() -> Sequence[Rung]:
    drift = _higher(_DIRECTION, "drift")
    place = _higher(drift, "slope", "friction slope")
    bent = _higher(place, "bow", "friction bow")
    still = _higher(_DIRECTION, "slope", "friction slope", "bow", "friction bow")
    return (
        (_PUBLISHED, None),
        (_DIRECTION, _PUBLISHED),
        (drift, _DIRECTION),
        (place, drift),
        (bent, place),
        (still, _DIRECTION),
    )


LADDER = _ladder()
_BENT = LADDER[4][0]
#: What tables and figures call them.
LABELS = (
    "published",
    "+ direction",
    "+ drift",
    "+ slope, friction slope",
    "+ bow, friction bow",
    "the last without drift",
)
#: What may be beside them, one by one: windows of 1 s alone.
ASIDE: Sequence[Rung] = (
    (_higher(_DIRECTION, "quadratic"), _DIRECTION),
    (_higher(_DIRECTION, "friction drift"), _DIRECTION),
    (Model(terms=("direction",), lag=1e-3), _DIRECTION),
    (_higher(_PUBLISHED, "stribeck"), _PUBLISHED),
    (_higher(_DIRECTION, "cogging"), _DIRECTION),
)
#: Of whose parameters a cycle gets two of its own.
TUNED = (_DIRECTION, _BENT)
#: Whose runs of the whole record are drawn.
SHOWN = tuple((label, m) for label, (m, _) in zip(LABELS, LADDER, strict=True))[:5]


def limits(data: Data, scores: Mapping[str, Scores], file: Path) -> dict[str, Any]:
    """What a force leaves by length of the windows, and what two numbers of a cycle buy."""
    if file.is_file():
        return dict(json.loads(file.read_text()))
    direction = _DIRECTION
    by_length = drifts(data, direction, scores[direction.words]["whole"].values[0])
    two = {
        model.words: {
            name: two_numbers(data, model, HORIZONS[name], scores[model.words]["half"].values)
            for name in ("1 s", "5 s")
        }
        for model in TUNED
    }
    searched = {
        label: {
            name: ends(data, m, HORIZONS[name], scores[m.words][name].values[0])
            for name in ("1 s", "whole")
        }
        for label, m in SHOWN[:4]
    }
    found = {
        "drifts": by_length,
        "two numbers": two,
        "offsets": offsets(data, direction),
        "ends": searched,
    }
    file.write_text(json.dumps(found))
    return found


def report(
    scores: Mapping[str, Scores], others: Mapping[str, Scores], limited: Mapping[str, Any]
) -> str:
    """Every table of the document."""
    lengths = " | ".join(f"{name} [um] | [N]" for name in LENGTHS)
    cycles = " | ".join(f"{name}: fitted | 1 | 2 | 3 | 4" for name in LENGTHS[:2])
    found = limited["drifts"]
    return "\n".join(
        [
            table("Ladder", f"model | parameters | {lengths}", ladder_table(scores, found)),
            table("Cycles held out, um", f"model | {cycles}", splits_table(scores)),
            table(
                "Other terms, held out, windows of 1 s",
                "model | parameters | [um]",
                [
                    [words, f"{len(of['1 s'].values[0])}", f"{1e6 * of['1 s'].error:.0f}"]
                    for words, of in others.items()
                ],
            ),
            table(
                f"{PUSH} N, um", "windows | as an offset | as friction", drifts_table(found, PUSH)
            ),
            table(
                "Two numbers, um",
                "model | windows | none | offset | offset and scale | of the cycle itself",
                numbers_table(limited["two numbers"]),
            ),
            table(
                "Each cycle by itself",
                "parameter | value [N]",
                [[n, f"{v:.2f} +- {sd:.2f}"] for n, (v, sd) in limited["offsets"].items()],
            ),
            table(
                "Ends of eight searches, um",
                "model | windows | each",
                [
                    [words, name, " ".join(f"{1e6 * e:.0f}" for e in each)]
                    for words, lengths in limited["ends"].items()
                    for name, each in lengths.items()
                ],
            ),
            *(
                table(words, f"parameter | {' | '.join(LENGTHS)}", parameters_table(of, names))
                for words, of in scores.items()
                for names in [[*of["1 s"].values[0]]]
            ),
        ]
    )


def main() -> None:
    """Print the tables, and write what they are made of and the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="DATA_EMPS.mat")
    parser.add_argument("--output", type=Path, default=Path("results"), help="a folder")
    arguments = parser.parse_args()
    folder = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    data = read_data(arguments.data)
    scores = climbed(data, folder / "emps_ladder.json", LADDER, rung, {})
    labelled = {label: scores[m.words] for label, (m, _) in zip(LABELS, LADDER, strict=True)}
    limited = limits(data, scores, folder / "emps_ladder_limits.json")
    others = climbed(data, folder / "emps_ladder_aside.json", ASIDE, aside, scores)
    print(report(labelled, others, limited))

    from emps_ladder_figures import draw  # imports Matplotlib

    for path in draw(data, labelled, SHOWN, folder):
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
