# %% [markdown]
# # One record through every room
#
# The program consists of rooms (packages), each with one subject. A room takes frozen objects from the rooms below it
# and returns its own; the first lines of its `__init__.py` say which. This page takes one record of the
# smallest axis from the first room to the last, and prints the objects between them.
#
# ## Modelling: an axis and its models
#
# An `Axis` is the declaration; nothing is derived yet.

# %%
import numpy as np

import axisid
from axisid.modeling.declaration import equation_of_motion
from axisid.modeling.library import LIBRARY

axis = axisid.load_axis("emps2015")
print(type(axis).__module__, type(axis).__name__, "of", len(LIBRARY), "in the library")
print(equation_of_motion(axis).text(axis.coordinate))

# %% [markdown]
# Derivation gives an `AxisModel`: regressors, the map between the parameters of the inverse and of the
# direct model, and the parameters that no motion can separate.

# %%
model = axisid.derive(axis)
print(type(model).__name__, [p.name for p in model.axis.parameters], model.unidentifiable)

# %% [markdown]
# ## Code: functions of the axis
#
# A `GeneratedAxis` has the same models as functions: CasADi functions, and compiled C if there is a compiler.

# %%
generated = axisid.build(axis)
print(type(generated).__name__, sorted(generated.functions))

# %% [markdown]
# ## Logs: a file as columns
#
# The twin's record is written in the format of a drive, and read again. A `Table` has columns by name,
# with their units as in the file. It does not depend on an axis.

# %%
import tempfile
from pathlib import Path

from axisid.estimation.logs import read_table

twin = axisid.twin_record(axis)
log = Path(tempfile.mkdtemp(), "log.csv")
columns = np.column_stack([1e3 * twin.time, twin.reference, 1e3 * twin.position, twin.control])
np.savetxt(log, columns, delimiter=";", header="t [ms];ref [m];pos [mm];u [V]", comments="")
table = read_table(log)
print(type(table).__name__, {name: column.unit for name, column in table.columns.items()})

# %% [markdown]
# ## Records: roles, SI, one clock
#
# A `Record` has the signals of an axis by role, in SI, on one clock. It lists assumptions and repairs.

# %%
roles = {"time": "t", "reference": "ref", "position": "pos", "control": "u"}
record = axisid.read_record(log, axis, columns=roles)
print(record)

# %% [markdown]
# ## Signals: a record under a filter
#
# A `Prefilter` has the user's settings. Bound to an axis and a record it becomes a `FilteredRecord`, which
# chooses the other settings and filters once.

# %%
from axisid.estimation.signals import FilteredRecord

data = FilteredRecord.bind(generated, record, axisid.Prefilter())
print(data.prefilter.hold, data.prefilter.reversals, len(data.excluded), "stretches left out")
print(
    type(data.signals).__name__,
    len(data.signals.velocity),
    "samples,",
    len(data.sampling.rows),
    "rows",
)

# %% [markdown]
# ## Regression: rows, solved
#
# A `Form` arranges signals as `y = X theta + known`. Input and output are arrays.

# %%
from axisid.estimation.regression import InverseForm, factor, least_squares

form = InverseForm(generated)
rows = form.equations(data.signals).reduced(data)
solution = least_squares(rows.left - rows.intercept, factor(rows.regressor, generated.names))
print(
    type(rows).__name__,
    rows.regressor.shape,
    "->",
    dict(zip(generated.names, solution.theta.round(2).tolist(), strict=True)),
)

# %% [markdown]
# ## Estimates: a problem and a method
#
# A `Problem` is an axis with its filtered records: one regression of one record, of one with gaps or of several.
# `RowTimes` says which rows follow each other in time. A `Method` of the table `METHODS` makes a `Fit` of the problem.
# The fit becomes an `Estimate` with covariances and the bias of the filter.

# %%
from axisid.estimation.estimation_problem import Problem
from axisid.estimation.methods import METHODS, estimate_by

second = FilteredRecord.bind(generated, axisid.twin_record(generated, seed=2), axisid.Prefilter())
problem = Problem(axis=generated, data=(data, second))
print(len(problem.neighbours), "rows in", len(problem.neighbours.lengths), "stretches")
print(type(METHODS["idm-iv"]).__name__, "->", estimate_by(problem, METHODS["idm-iv"]))

# %% [markdown]
# ## Identification and diagnosis
#
# `identify` runs the methods on one record. The `Identification` holds an `Estimate` for each method and the
# `Diagnosis`: a `Check` from each row of the table `DIAGNOSTICS`. `identify(judge=False)` leaves it until it is read.
# The finding of a check is data; the room `presentation` has its sentence.

# %%
result = axisid.identify(generated, record)
for method, estimate in result.estimates.items():
    print(method, estimate.parameters["M"])
for check in result.diagnosis.verdict[:3]:
    print(type(check).__name__, check.name, check.status, check.finding)

# %% [markdown]
# ## Studies
#
# Many identifications, or the comparison of one with other data: `sweep`, `compare`, `validate`.

# %%
print(axisid.validate(result, record))

# %% [markdown]
# ## Presentation
#
# Results hold data. Separate rooms make text, JSON, figures, notebooks and the report from them; no room below
# imports these. The text of a result is a document of blocks. Plain text, a terminal and a notebook are
# three renderings of it.

# %%
from axisid.presentation.views import as_blocks

print([type(block).__name__ for block in as_blocks(result)])

# %%
print(sorted(result.to_dict()))
result.plot("friction")
