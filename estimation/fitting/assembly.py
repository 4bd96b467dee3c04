"""From where a search ended to a result."""

import math
from typing import Literal

import numpy as np

from axisid.estimation.estimates import Value, student_interval
from axisid.estimation.parameters import are_starts
from axisid.estimation.predictions import (
    record_rows,
)
from axisid.support.arrays import Array

from .ended import Ended
from .judgement import judged
from .result import FitBasis, OutputFit, RecordError


def assembled(ended: Ended) -> OutputFit:
    """The result of a fit."""
    u, names = ended.unknowns, ended.unknowns.names
    at_bound: dict[str, Literal["lower", "upper"]] = {
        n: "lower" if side < 0 else "upper"
        for n, side in zip(names, ended.at_bound, strict=True)
        if side
    }
    return OutputFit(
        axis=ended.axis,
        records=ended.records,
        outputs=ended.outputs,
        units=ended.predictions.units,
        loss=ended.loss,
        quantities=ended.unknowns.quantities,
        physical=ended.physical,
        covariances=ended.covariances,
        chosen=ended.chosen,
        values=_values(ended),
        at_bound=at_bound,
        bounds={n: (float(a), float(b)) for n, a, b in zip(names, u.lower, u.upper, strict=True)},
        fixed={names[j]: float(u.fixed[j]) for j in np.flatnonzero(~u.free)},
        prior={
            names[j]: (float(u.prior[j]), float(u.prior_sd[j])) for j in np.flatnonzero(u.has_prior)
        },
        unseen=ended.unseen.texts(names),
        local=ended.whose.local,
        start=ended.begun,
        started=ended.start.named,
        remarks=ended.remarks,
        steps=ended.best.steps,
        ends=tuple((each.cost, each.physical) for each in ended.ends),
        of_records=_of_records(ended),
        errors=_errors(ended),
        samples=ended.predictions.samples,
        horizon=ended.horizon,
        basis=FitBasis(
            axes=ended.axes,
            own=ended.own,
            chains=() if ended.twins is None else ended.twins.chains,
            predictions=ended.predictions,
            best=ended.best,
            ends=ended.ends,
            influence=ended.influence,
            beyond=ended.beyond,
            scores=ended.judged_scores,
            weights=ended.weighing.weights,
            inner=ended.inner,
            known=ended.known,
            alone=ended.told_alone,
            moved=ended.moved,
            by_start=ended.by_start,
            elsewhere=ended.elsewhere,
            why_not_moved=ended.twins_or_why if isinstance(ended.twins_or_why, str) else "",
            of_start=are_starts(ended.whose.form),
            rests_count=ended.rests.count,
        ),
        judge=judged,
    )


def _values(ended: Ended) -> dict[str, Value]:
    found, chosen, freedom = {}, ended.chosen, ended.freedom
    for j, q in enumerate(ended.unknowns.quantities):
        value = float(ended.physical[j])
        # What is hardly shown may have a variance that rounding made negative.
        variances = {n: float(c[j, j]) for n, c in ended.covariances.items()}
        deviations = {n: math.sqrt(v) if v >= 0 else math.inf for n, v in variances.items()}
        if ended.at_bound[j]:
            interval = ended.one_sided(j)
        else:
            interval = student_interval(value, deviations[chosen], float(freedom[j]))
        found[q.name] = Value(
            value=value, unit=q.unit, deviations=deviations, interval=interval, chosen=chosen
        )
    return found


def _of_records(ended: Ended) -> tuple[RecordError, ...]:
    errors, measured = ended.best.slopes.errors, ended.predictions.measured
    counted, found = ended.weighing.weights > 0, []
    for spans, model in zip(ended.predictions.spans, ended.autoregressions, strict=True):
        for place, output in enumerate(ended.outputs):
            rows = record_rows(spans, place, len(ended.outputs))
            used = counted[rows]
            e, y = errors[rows][used], measured[rows][used]
            left, size = float(np.linalg.norm(e)), float(np.linalg.norm(y))
            found.append(
                RecordError(
                    output=output,
                    unit=ended.predictions.units[place],
                    weight=float(ended.weighing.weights[rows].max()),
                    rows=int(used.sum()),
                    error=left / max(len(e), 1) ** 0.5,
                    percent=100 * left / size if size else float("inf") if left else 0.0,
                    order=model.order,
                )
            )
    return tuple(found)


def _errors(ended: Ended) -> tuple[Array, ...]:
    errors, count = ended.best.slopes.errors, len(ended.outputs)
    whole = (errors[record_rows(spans)] for spans in ended.predictions.spans)
    return tuple(whole) if count == 1 else tuple(each.reshape(-1, count) for each in whole)
