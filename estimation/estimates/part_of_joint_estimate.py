"""The part of one record in an estimate from several: its rows and its parameters."""

from dataclasses import replace

import numpy as np

from axisid.estimation.estimation_problem import Problem
from axisid.estimation.regression import (
    LossWeights,
    condition_number,
    simulated_loops,
    simulated_rows,
)
from axisid.estimation.unknowns import JointForm
from axisid.support.arrays import Array, relative_error_percent

from .estimate import Estimate, NotSimulated


def estimate_of_record(estimate: Estimate, problem: Problem, record: int) -> Estimate:
    """Return the part of an estimate that belongs to one record, in the parameters of its axis.

    If the drive gain is among the parameters of all records, the parameters of the record are
    relative to the declared gain, as its force is.

    Parameters
    ----------
    estimate : Estimate
    problem : Problem
        Problem that the estimate was made from.
    record : int
        Index of the record.
    """
    # The rows of this record, with the parameters of the whole estimate.
    data, span = problem.data[record], problem.spans[record]
    left, residuals, counts = estimate.y[span], estimate.residuals[span], estimate.counts
    simulated, inference = estimate.simulated, estimate.inference
    simulation_error = None
    if not isinstance(simulated, NotSimulated):
        simulated = simulated[span]
        if len(left):
            simulation_error = relative_error_percent(left - simulated, left)
    if counts is not None:
        counts = LossWeights(weights=counts.weights[span], slopes=counts.slopes[span])
    with_rows = replace(
        estimate,
        y=left,
        rows=data.sampling.rows,
        neighbours=data.sampling.neighbours,
        times=data.times_of_rows if data.record.segments else None,
        period=data.period,
        residuals=residuals,
        simulated=simulated,
        equation_error_percent=relative_error_percent(residuals, left) if len(left) else 0.0,
        simulation_error_percent=simulation_error,
        weights=np.ones(len(left)),
        counts=counts,
    ).with_inference(
        noise_free=_rows_of(inference.noise_free, span),
        chains=inference.chains[record : record + 1],
        twins_residuals=_rows_of(inference.twins_residuals, span),
    )
    # If all records share all parameters, only the columns remain to be cut out.
    if not isinstance(estimate.form, JointForm):
        X, Z = estimate.X[span], _rows_of(estimate.Z, span)
        return replace(with_rows, X=X, Z=Z, condition_number=condition_number(X))
    return _in_own_parameters(with_rows, estimate.form, problem, record)


def _rows_of(values: Array | None, span: slice) -> Array | None:
    """Return the rows of one record, a slice of all rows; None for missing values."""
    return None if values is None else values[span]


def _in_own_parameters(part: Estimate, form: JointForm, problem: Problem, record: int) -> Estimate:
    """Return the part of one record in the parameters of that record's axis.

    Values and covariances are mapped from the parameters of all records to those of the record.
    Regressor and instruments are computed again for the record alone.

    Parameters
    ----------
    part : Estimate
        Rows of the record, with the parameters of all records.
    form : JointForm
        Map from the parameters of all records to those of each record.
    problem : Problem
    record : int
        Index of the record.
    """
    data, axis = problem.data[record], problem.data[record].axis
    physical = form.own(part.physical, record)
    # Derivatives of the record's parameters by those of all records.
    slopes = form.record_jacobian(record) @ np.linalg.inv(part.jacobian)
    form_of_record = form.of_record(record)
    X, Z = form_of_record.equations(data.signals).reduced(data).regressor, None
    if part.Z is not None:
        loops = simulated_loops(axis, data.record, physical)
        Z = simulated_rows(form_of_record, loops, physical, data).regressor
        X = Z if part.by_output_error else X
    by_gain = part.inference.gain_slopes
    by_gain = None if by_gain is None else slopes @ by_gain
    distribution = part.distribution.through(axis.parameters, physical, slopes)
    return replace(
        part,
        form=form_of_record,
        quantities=axis.parameters,
        theta=physical,
        physical=physical,
        jacobian=np.eye(len(physical)),
        X=X,
        Z=Z,
        condition_number=condition_number(X),
        iterates=(),
    ).with_inference(
        covariances=distribution.covariances,
        freedom=distribution.freedom,
        gain_slopes=by_gain,
        theta_gain_slopes=by_gain,
        bias=distribution.bias,
    )
