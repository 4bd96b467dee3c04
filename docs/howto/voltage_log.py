# %% [markdown]
# # My log has PWM or voltage, not current
#
# A current makes a torque at any speed. A voltage does not: the back-EMF, `ke` times the motor speed, is
# subtracted from it, and the rest drives a current through the winding. You can declare such a drive as a plain gain,
# `Drive(gain=kt*n/R)`. The fit is as good, but the viscous friction then contains that of the bearings *and*
# `kt*ke*n^2/R`, which is often larger. If you declare the drive, you get the friction of the axis alone.
#
# ## From the data sheet
#
# A servo of a robot hand logs its PWM duty, from -885 to 885. Its data sheet says: 12 V, stall torque 4.1 N m at 2.3 A,
# no-load speed 46 rpm, gear ratio 353.5. The resistance is `12/2.3`. The no-load speed, where hardly any current flows,
# gives `ke`. `kt` is the same number in SI. The ratio of the stall torque to `kt*n*2.3` is the efficiency of the gear.

# %%
import math
from dataclasses import replace

from axisid import Coordinate, Parameter, identify, newton, twin_record
from axisid.control import dynamixel_position
from axisid.elements import Drive, back_emf, coulomb, gravity_moment, viscous, voltage_drive
from axisid.modeling import Experiment, back_and_forth

volts, amperes, ratio = 12.0, 2.3, 353.5
resistance = volts / amperes
ke = volts / (ratio * 46 * 2 * math.pi / 60)
efficiency = 4.1 / (ke * ratio * amperes)
print(f"R = {resistance:.3g} V/A, ke = kt = {1e3 * ke:.3g} mN m/A, efficiency {efficiency:.2f}")

motor = {"kt": ke, "resistance": resistance, "ratio": ratio, "volts": volts / 885}
drive = voltage_drive(ke=ke, efficiency=efficiency, unit="1", limit=885.0, **motor)

q = Coordinate("q", "rad")
J = Parameter("J", "kg m^2", nominal=0.02, lower=0.0, description="finger and rotor")
mgl = Parameter("mgl", "N m", description="weight, level at 0")
fv = Parameter("fv", "N m/(rad/s)", lower=0.0)
fc = Parameter("fc", "N m", lower=0.0)

axis = newton(
    "finger",
    coordinate=q,
    parameters=(J, mgl, fv, fc),
    inertia=J,
    resistance=(gravity_moment(0, mgl, q), viscous(fv, q), coulomb(fc, q)),
    drive=drive,
    control=dynamixel_position(p=800.0, d=100.0, period=1e-3),
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.5, 1.2, 2.5), acceleration=25.0, seconds=0.6, repeat=3),
        truth={"J": 0.024, "mgl": 0.4, "fv": 0.03, "fc": 0.12},
        position_noise=1e-5,
    ),
)
record = twin_record(axis)
right = identify(axis, record)
print(right["idm-iv"].parameters.listed())

# %% [markdown]
# The same record with a plain gain: the viscous friction is forty times that of the axis, and the losses of the gear
# affect every parameter.

# %%
gain = replace(axis, drive=Drive(gain=drive.gain, unit="1", limit=885.0))
wrong = identify(gain, record, methods=["idm-ls"])
print(wrong["idm-ls"].parameters.listed())

# %% [markdown]
# `volts` is the voltage for a control of 1: the supply for a duty from -1 to 1, `supply/255` for an 8-bit PWM. For a
# recorded supply that varies, use `scaled_by=supply/12`, see [Recorded signals](recorded_signals.py). In TOML:
#
# ```toml
# drive = { kind = "voltage_drive", kt = 7.05e-3, ke = 7.05e-3, resistance = 5.22, ratio = 353.5, efficiency = 0.72, volts = 0.01356, unit = "1", limit = 885 }
# ```
#
# ## Without `ke`
#
# Without `ke` the drive is a gain. The identified viscous friction is then `fv + kt*ke*n^2/R`, and the text of every
# result says so. No motion separates the two: both are proportional to the speed, so they are one column of the
# regression. If the friction is known (from a run with open motor terminals), the back-EMF can be identified as a
# parameter of the equation of motion. If neither is known, `show` names the identifiable sum.

# %%
KE = Parameter("ke", "V/(rad/s)", lower=0.0)
emf = back_emf(KE, q, kt=ke, resistance=resistance, ratio=ratio)
both = replace(
    axis,
    drive=voltage_drive(unit="1", limit=885.0, **motor),
    parameters=(J, mgl, fv, fc, KE),
    force=axis.force + emf,
    experiment=replace(axis.experiment, truth={**axis.experiment.truth, "ke": ke}),
)
summed = identify(both, twin_record(both), methods=["idm-iv"])
print(summed["idm-iv"].parameters.listed())

# %% [markdown]
# ## Which one do I have?
#
# | the log has | declare |
# |---|---|
# | current, measured or commanded in a current loop | `Drive(gain=kt*n, unit="A")`, or `current_drive(kt=, ratio=, ...)` |
# | current, near the limit of the supply | `current_drive(kt=, ratio=, supply=, resistance=, ke=)`: the torque falls with the speed there |
# | voltage, or a PWM duty | `voltage_drive(kt=, ke=, resistance=, ratio=, volts=)` |
# | the same, `L/R` of the winding above a tenth of the sampling period | the same with `inductance=` |
# | either, behind a worm or a high gear | the same with `efficiency=` |
# | something else | `formula_drive(force, inverse)` |
#
# [Drives](../drives.md) has the equations, measurements of each drive, and what no record can show.
