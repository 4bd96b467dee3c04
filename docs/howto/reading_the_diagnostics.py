# %% [markdown]
# # Read the diagnostics
#
# A wrong unit, sign or clock leaves a perfect-looking fit. Under every result there is a verdict: a list of
# checks, each with its figure, its threshold, the source of the threshold, and a sentence that says what it
# means: *pass*; *note*, beyond the threshold, but the deviations and intervals that are printed allow for it;
# *fail*, a reason to look; or *not evaluated*. One sentence above them says whether the numbers can be believed.
#
# Here a good record is spoilt on purpose, to see what each fault looks like.

# %%
from dataclasses import replace
from textwrap import fill

import numpy as np

import axisid

axis = axisid.build(axisid.load_axis("emps2015"))
record = axisid.twin_record(axis)


def failures(changed: axisid.Record) -> None:
    """What fails on a record."""
    result = axisid.identify(axis, changed)
    values = ", ".join(f"{n} {v.value:.4g}" for n, v in result["idm-ls"].parameters.items())
    print(f"IDM-LS: {values}; equation error {result['idm-ls'].equation_error_percent:.1f} %")
    for reason in set(result.failed.values()):
        print(fill(str(reason), 88, initial_indent="      ", subsequent_indent="      "))
    for check in result.verdict:
        if check.status == "fail":
            print(fill(f"FAIL  {check.line}: {check.meaning}", 88, subsequent_indent="      "))


failures(record)

# %% [markdown]
# On the good record nothing fails.
#
# ## The control is logged with another gain
#
# An ADC or a scaling of the drive makes the control 10 % larger. The fit is as good as before: the mass is
# just 10 % larger too.

# %%
failures(replace(record, control=1.1 * record.control))

# %% [markdown]
# ## Millimetres taken for metres

# %%
failures(replace(record, reference=1e3 * record.reference, position=1e3 * record.position))

# %% [markdown]
# ## A flipped sign

# %%
failures(replace(record, control=-record.control))

# %% [markdown]
# ## The control is logged two samples late

# %%
failures(replace(record, control=np.roll(record.control, 2)))

# %% [markdown]
# ## A term that the model lacks
#
# A record of the same axis with a force of 15 N that depends on the position, as of cogging:

# %%
import sympy

from axisid import Constant

declared = axis.declared
size, pitch = Constant(15.0, "N", "size"), Constant(40.0, "1/m", "pitch")
cogging = size * sympy.sin(pitch * declared.coordinate.symbol)
failures(axisid.twin_record(replace(declared, force=declared.force + cogging)))

# %% [markdown]
# ## A motion that does not show a parameter
#
# One slow move in one direction: viscous and Coulomb friction look alike. The deviations say so, and the
# reason is given in words. Instruments do not help.

# %%
slow = (axisid.modeling.Move(distance=0.05, speed=0.02, acceleration=2.0),)
experiment = replace(declared.experiment, moves=slow)
failures(axisid.twin_record(replace(declared, experiment=experiment)))

# %% [markdown]
# ## A term that the motion does not show at all
#
# Stribeck friction at speeds that the axis passes in a sample or two. There is no number to print: the
# parameter is named, with what it would have to be. Without it the others are as good as ever.

# %%
Fs = axisid.Parameter("Fs", "N", nominal=10.0)
slope = axisid.elements.stribeck(Fs, declared.coordinate, velocity=1e-3)
richer = replace(declared, parameters=(*declared.parameters, Fs), force=declared.force + slope)
try:
    axisid.identify(richer, record)
except axisid.EstimationError as refused:
    print(fill(str(refused), 88))
print(axisid.identify(axisid.leave_out(richer, "Fs"), record)["idm-iv"])

# %% [markdown]
# ## The checks
#
# A verdict has eight lines. What fails stands first, with what to do about it; what passed is one line of
# names; what is only noted is printed with `--all`. `--full` and `--json` have each check behind them.
#
# | line | check | fails where | what to do |
# |---|---|---|---|
# | law | control law | the law's terms do not add up to the recorded control (5 % of its norm), one of its factors is off by more than 1 %, it is late, or its scale is wrong by what moves a parameter by more than two standard errors. Not evaluated where a log that rounds, or is slower than the law, leaves open more than a third of what is off; the sentence above the checks says so. In a fit, factors of a tenth at most that move no parameter by more count once, as *law's factors* | the factors name the unit, sign, gain or delay; mend it first. Where none explains it, `axisid law` finds which ready law the control is of |
# |  | noise gain | without a reference: the noise of the position returns in the control by another factor than the declared law has (beyond 1.25 either way). Left out where this noise does not dominate the control at high frequencies | the units of the position and the control, the gains and the period of the law |
# |  | force against control | in what is slow against a current loop the force column is more than 20 % off the gain times the control, later than 5 ms, or off by a factor beyond 1 % and three deviations | the column's scale, or the gain and how well it is known |
# | timing | sudden steps | one step of a position in motion differs from its neighbours by more than twice the largest second difference of steps elsewhere; the sentence says whether samples are missing or repeated, the encoder was stuck, or the position starts again | leave the place out with `windows`, or mend the recorder; declare `wrap` |
# |  | alignment | the model lacks a delay, by the search for missing terms; the sentence says where the force fits the motion best | `hold`, the drive's delay or lag that is missing or declared too long, or the clock of the log (a note where the control law says so too); what other checks say of reversals, or of friction with a delay declared too long, is a note then |
# | loop | simulation | the simulated loop leaves half of the force unexplained, or cannot be simulated with the estimate | law, signs, units; or the record is mostly noise. Where the law is right and *model* fails, mend that first |
# |  | control against limit | the control is beyond the drive's limit in more than 0.1 % of the samples; a note where the force is measured | record what the drive applies; the limit, the unit |
# | model | fixed values | what was fixed contradicts the record | the fixed value, or the model |
# |  | missing terms | the residuals hold more of a term, or of a change in time, than those of twins of the record do, and it is 1 % of the force or moves a parameter by more than its interval | declare what is named, and identify again |
# | outliers | outliers | a single sample of what was measured leaves its course by more than in twins of the record, and it is 1 % of the force or moves a parameter by more than its interval; a note with `--loss` | empty such cells and read with `--resample auto`, or `--loss huber` |
# | precision | precision | a parameter's deviation exceeds 30 % of it, unless it is known to be small wherever the axis was | the sentence says why the record does not show it; `--leave-out` does without it |
# |  | bounds | a value is outside its declared bounds | signs and units |
# |  | nominal values | a note: a value, with its whole interval, is more than 5 times its nominal one, or less than a fifth | units of the columns, the drive's gain |
# | method | instrument strength | the first-stage F of a column, given the others, is below 10 | the simulated loop does not move like the axis, or the motion is too poor |
# |  | method | IDM-IV less the bias of filter and noise and DIDIM differ by more than chance (Hausman, all differences at once, 1 %), half a deviation and 1 % of the value, beyond the interval of either; or the steps of a logged position that no control answers to move least squares by half a deviation and 1 %. A note where less, and for what noise does to least squares | the sentence says which to believe: DIDIM where the control law passes its check, else the instruments; lower the cut-off, or log the position as finely as the drive measures it |
# |  | inverse against direct | without instruments, the two forms of least squares differ by as much | a fit of the position under the recorded control |
#
# `--json` has the figure, the threshold and its source of each; see [Results as JSON](../results.md).
# [The DFKI pendulum](../dfki_pendulum.md) shows what they are worth on a difficult real record.
