# %% [markdown]
# # Read the diagnostics
#
# A fit can look perfect with a wrong unit, sign or clock. Therefore every result has a verdict: a list of checks. Each
# check has its figure, its threshold, the source of the threshold, its finding (`check.finding`: numbers, names and units),
# a sentence made of the finding (`check.meaning`), and a status:
#
# - *pass*;
# - *note*: beyond the threshold, but the printed standard errors and intervals allow for it;
# - *fail*: a reason to look;
# - *not evaluated*.
#
# The headline above them says whether you can use the numbers: "All checks passed.", "Use with care: ..." or "Do not
# use these numbers: ...", with the reason. Below, faults are put into a good record, to show what each looks like.

# %%
from dataclasses import replace
from textwrap import fill

import numpy as np

import axisid

axis = axisid.build(axisid.load_axis("emps2015"))
record = axisid.twin_record(axis)


def failures(changed: axisid.Record) -> None:
    """Print the failed checks of a record."""
    result = axisid.identify(axis, changed)
    values = ", ".join(f"{n} {v.value:.4g}" for n, v in result["idm-ls"].parameters.items())
    print(f"IDM-LS: {values}; equation error {result['idm-ls'].equation_error_percent:.1f} %")
    for reason in set(result.failed.values()):
        print(fill(str(reason), 88, initial_indent="      ", subsequent_indent="      "))
    for check in result.verdict:
        if check.status == "fail":
            print(fill(f"FAIL  {check.line}: {check.meaning}.", 88, subsequent_indent="      "))


failures(record)

# %% [markdown]
# No check fails on the good record.
#
# ## The control is logged with another gain
#
# An ADC or a scaling of the drive makes the control 10 % larger. The fit is as good as before, but the mass is
# 10 % larger too.

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
# ## A missing term
#
# A record of the same axis with an additional cogging force of 15 N, which depends on the position:

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
# In one slow move in one direction, viscous and Coulomb friction cannot be separated. The standard errors show
# this, and a sentence gives the reason. Instrumental variables (IV) do not help.

# %%
slow = (axisid.modeling.Move(distance=0.05, speed=0.02, acceleration=2.0),)
experiment = replace(declared.experiment, moves=slow)
failures(axisid.twin_record(replace(declared, experiment=experiment)))

# %% [markdown]
# ## A term that the motion does not show at all
#
# An example is Stribeck friction at speeds that the axis passes in one or two samples. There is no number to
# print. The program names the parameter, and the value that it would need to be visible. Without it, the other
# parameters are as good as before.

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
# A verdict has eight lines. Failed lines come first, with the remedy. Passed lines are one line of
# names. `--all` prints notes. `--full` and `--json` have every check.
#
# | line | check | fails if | what to do |
# |---|---|---|---|
# | law | control law | the law's terms do not add up to the recorded control (5 % of its norm), one of its factors is off by more than 1 %, the control is late, or a wrong scale of it moves a parameter by more than two standard errors. Not evaluated if rounding of the log, or a log slower than the law, leaves more than a third of the error unresolved; the sentence above the checks says so. In a fit, factors off by at most a tenth that move no parameter by more appear as *law's factors* only | correct the unit, sign, gain or delay that the factors show, before anything else. If none explains it, `axisid law` finds the built-in law of the control |
# |  | noise gain | without a reference: the gain from position noise to control differs from that of the declared law (by a factor beyond 1.25 either way). Left out if this noise does not dominate the control at high frequencies | check the units of position and control, gains and period of the law |
# |  | force against control | at frequencies well below the current loop, the force column differs from gain times control by more than 20 %, is later than 5 ms, or is off by a factor beyond 1 % and three standard errors | check the scale of the column, or the gain and its uncertainty |
# | timing | sudden steps | one step of a moving position differs from its neighbours by more than twice the largest second difference of steps elsewhere. The sentence says whether samples are missing or repeated, the encoder was stuck, or the position starts again | leave the place out with `windows`, or repair the recorder; declare `wrap` |
# |  | alignment | the search for missing terms finds a delay. The sentence gives the delay at which the force fits the motion best | correct `hold`, the drive's delay or lag (missing, or declared too long), or the clock of the log (a note if the control law says so too). What other checks find at reversals, or in friction with a delay declared too long, is then a note |
# | loop | simulation | the simulated loop does not explain half of the force, or cannot be simulated with the estimate | check law, signs, units; or the record is mostly noise. If the law is right and *model* fails, correct the model first |
# |  | control against limit | the control is beyond the drive's limit in more than 0.1 % of the samples; a note if the force is measured | record the applied control; check the limit, the unit |
# | model | fixed values | a fixed value contradicts the record | check the fixed value, or the model |
# |  | missing terms | the residuals contain more of a term, or of a change in time, than those of simulated replicas do, and it is 1 % of the force or moves a parameter by more than half the width of its interval | declare the named term, and identify again |
# | outliers | outliers | a single measured sample leaves its course by more than in simulated replicas, and it is 1 % of the force or moves a parameter by more than half the width of its interval; a note with `--loss` | empty such cells and read with `--resample auto`, or use `--loss huber` |
# | precision | precision | the standard error of a parameter exceeds 30 % of it, unless its effect is known to be small over the whole motion | the sentence gives the reason. Record a motion without this limitation, add the missing terms, or fix a known value with `--fix` |
# |  | bounds | a value is outside its declared bounds | check signs and units |
# |  | nominal values | a note: a value, with its whole interval, is more than 5 times its nominal value, or less than a fifth | check units of the columns, the drive's gain |
# | method | instrument strength | the first-stage F of a column, given the others, is below 10 | the simulated loop does not move like the axis, or the motion is too poor |
# |  | method | IDM-IV (minus the bias of filter and noise) and DIDIM differ by more than chance (Hausman, all differences at once, 1 %), half a standard error and 1 % of the value, beyond the interval of either. Or the steps of a logged position, to which no control reacts, move least squares by half a standard error and 1 %. A note if less, and for bias of least squares from noise | the sentence says which is reported: DIDIM if the recorded control follows the declared law, otherwise IDM-IV. Lower the cut-off, or log the position with the drive's resolution |
# |  | inverse against direct | without IV, the two forms of least squares differ by as much | fit the position under the recorded control |
#
# `--json` has figure, threshold, source and finding of each check; see [Results in files and programs](../results.md).
# [The DFKI pendulum](../dfki_pendulum.md) shows the checks on a difficult real record.
