"""From the solution of a fit to its result."""

import math
from typing import Literal

import numpy as np

from axisid.estimation.estimates import Value, student_interval
from axisid.estimation.predictions import (
    record_rows,
)
from axisid.support.arrays import Array

from .judgement import judged
from .result import OutputFit, RecordError
from .solution import FitSolution


def assembled(solution: FitSolution) -> OutputFit:
    """The result of a fit."""
    u, names = solution.unknowns, solution.unknowns.names
    at_bound: dict[str, Literal["lower", "upper"]] = {
        n: "lower" if side < 0 else "upper"
        for n, side in zip(names, solution.at_bound, strict=True)
        if side
    }
    return OutputFit(
        axis=solution.axis,
        records=solution.records,
        outputs=solution.outputs,
        units=solution.predictions.units,
        loss=solution.loss,
        quantities=solution.unknowns.quantities,
        physical=solution.physical,
        covariances=solution.covariances,
        chosen=solution.chosen,
        values=_values(solution),
        at_bound=at_bound,
        bounds={n: (float(a), float(b)) for n, a, b in zip(names, u.lower, u.upper, strict=True)},
        fixed={names[j]: float(u.fixed[j]) for j in np.flatnonzero(~u.free)},
        prior={
            names[j]: (float(u.prior[j]), float(u.prior_sd[j])) for j in np.flatnonzero(u.has_prior)
        },
        unseen=solution.unseen.texts(names),
        local=solution.whose.local,
        start=solution.begun,
        started=solution.start.named,
        remarks=solution.remarks,
        steps=solution.best.steps,
        ends=tuple((each.cost, each.physical) for each in solution.ends),
        of_records=_of_records(solution),
        errors=_errors(solution),
        samples=solution.predictions.samples,
        horizon=solution.horizon,
        solution=solution.evaluated(),
        judge=judged,
    )


def _values(solution: FitSolution) -> dict[str, Value]:
    found, chosen, freedom = {}, solution.chosen, solution.freedom
    for j, q in enumerate(solution.unknowns.quantities):
        value = float(solution.physical[j])
        # What is hardly shown may have a variance that rounding made negative.
        variances = {n: float(c[j, j]) for n, c in solution.covariances.items()}
        deviations = {n: math.sqrt(v) if v >= 0 else math.inf for n, v in variances.items()}
        if solution.at_bound[j]:
            interval = solution.one_sided(j)
        else:
            interval = student_interval(value, deviations[chosen], float(freedom[j]))
        found[q.name] = Value(
            value=value, unit=q.unit, deviations=deviations, interval=interval, chosen=chosen
        )
    return found


def _of_records(solution: FitSolution) -> tuple[RecordError, ...]:
    errors, measured = solution.best.slopes.errors, solution.predictions.measured
    counted, found = solution.weighing.weights > 0, []
    for spans, model in zip(solution.predictions.spans, solution.autoregressions, strict=True):
        for place, output in enumerate(solution.outputs):
            rows = record_rows(spans, place, len(solution.outputs))
            used = counted[rows]
            e, y = errors[rows][used], measured[rows][used]
            left, size = float(np.linalg.norm(e)), float(np.linalg.norm(y))
            found.append(
                RecordError(
                    output=output,
                    unit=solution.predictions.units[place],
                    weight=float(solution.weighing.weights[rows].max()),
                    rows=int(used.sum()),
                    error=left / max(len(e), 1) ** 0.5,
                    percent=100 * left / size if size else float("inf") if left else 0.0,
                    order=model.order,
                )
            )
    return tuple(found)


def _errors(solution: FitSolution) -> tuple[Array, ...]:
    errors, count = solution.best.slopes.errors, len(solution.outputs)
    whole = (errors[record_rows(spans)] for spans in solution.predictions.spans)
    return tuple(whole) if count == 1 else tuple(each.reshape(-1, count) for each in whole)
