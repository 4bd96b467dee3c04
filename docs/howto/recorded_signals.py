# %% [markdown]
# # Recorded signals in the model
#
# A pressure, a temperature, a supply voltage, the acceleration of another axis, a feed-forward of a machine's
# controller: a column of the log that is no motion of this axis may stand in the equation of motion, in the drive
# or in the control law. It is a `Signal`, with a name, a unit, and how it runs between the samples of a log:
# `"linear"`, the default, or `"held"` for what a controller gives once a sample.
#
# A vertical axis with a pneumatic counter-balance. Its pressure swings as the slide moves; the area on which it acts is
# a parameter, told apart from the constant load as the pressure varies by itself:

# %%
import sympy

from axisid import Coordinate, Parameter, Signal, identify, newton, twin_record
from axisid.control import cascade_pd_averaged
from axisid.elements import TIME, Drive, coulomb, offset, viscous
from axisid.modeling import Experiment, back_and_forth

q = Coordinate("q", "m")
M = Parameter("M", "kg", nominal=80.0, lower=0.0)
Fv, Fc = Parameter("Fv", "N/(m/s)"), Parameter("Fc", "N")
load = Parameter("load", "N", description="weight")
area = Parameter("area", "m^2", nominal=1e-3, description="of the cylinder")
pressure = Signal("pressure", "Pa", description="in the cylinder")
supply = Signal("supply", "V", "held", description="of the amplifier")

axis = newton(
    "balanced",
    coordinate=q,
    parameters=(M, Fv, Fc, load, area),
    signals=(pressure, supply),
    inertia=M,
    resistance=(viscous(Fv, q), coulomb(Fc, q), offset(load), -area * pressure),
    drive=Drive(gain=35.0, scaled_by=supply / 48),  # an amplifier without a supply of its own
    control=cascade_pd_averaged(kp=30.0, kv=300.0, period=1e-3),
    columns={"pressure": "p:bar"},
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.1, 0.3, 0.5), acceleration=5.0, seconds=0.6, repeat=2),
        truth={"M": 90.0, "Fv": 200.0, "Fc": 20.0, "load": 600.0, "area": 1.1e-3},
        position_noise=1e-6,
        signals={
            "pressure": 5.5e5 + 4e4 * sympy.sin(5 * TIME) + 2e4 * sympy.sin(17 * TIME),
            "supply": 48 + sympy.sin(3 * TIME),
        },
    ),
)
result = identify(axis, twin_record(axis))
print(result.summary())

# %% [markdown]
# `Experiment(signals=...)` says what they are in the twin, by the time; `simulate`, `simulate_batch` and
# `twin_record` take arrays by name, `signals={"pressure": values}`, one value for each sample of the reference.
#
# In TOML:
#
# ```toml
# [signals]
# pressure = { unit = "Pa", description = "in the cylinder" }
# supply = { unit = "V", between = "held" }
#
# [newton]
# inertia = "M"
# resistance = ["Fv*dq", "Fc*sign(dq)", "load", "-area*pressure"]
#
# [drive]
# gain = 35.0
# scaled_by = "supply/48"
#
# [columns]
# pressure = "p:bar"
# ```
#
# Of a log each signal is a column like any other: named by `[columns]` or `--columns pressure=p:bar`, else by its own name,
# with a unit or a scaling, shifted, windowed, resampled as it runs. A log without it is refused.
#
# ## Where a signal may stand
#
# | | |
# |---|---|
# | equation of motion | any expression with the motion and the parameters: `-area*pressure`, `k*temperature*dq`, `m*other_ddq` |
# | drive | `scaled_by`, a number of signals and constants that the gain is times; `profile`; the force of a drive class of your own |
# | control law | its output and what its memory becomes: a feed-forward, a commanded velocity |
#
# It varies by itself, so that products of a parameter and a signal are base parameters of their own. An inertia with a
# signal in it leaves no direct regressor, and no Lagrangian: how fast it changes is not recorded.
#
# ## What is done with it
#
# In the rows a signal stands as the force does: as it was recorded, not low-passed, since nothing is differentiated.
# Products with the motion are made sample by sample, and both sides then take the same decimation filter. Of a held signal
# it is the mean of what is held before and after a sample, to which the acceleration belongs.
#
# The check `recorded signals` holds each against the force that it makes: a column that was logged late or early is told
# with its delay and the `shift` that mends it, and one in another unit (bar read as Pa) with its factor where its
# coefficient is known. Where that is estimated, it takes the factor on itself: the verdict says that the signal's
# scale rests on its column and unit alone. The library has such an axis, `balanced_slide`.
#
# In a simulation the plant sees it between samples as it is declared, so that a stuck axis leaves rest within a sample
# where a straight signal overcomes its friction. A sampled law and its drive read it when the law is evaluated; the force is
# held then. Of a log that is slower or faster than the law it is taken between the log's samples. Where a contact's *place*
# moves with a signal (`Max(0, q - wall)`), or a signal passes a place by itself (`Piecewise` over a temperature), the
# crossing is located within the sample: a mass of 2 kg against a wall that comes and goes, of 2e4 and 3e6 N/m at 1 kHz, is within
# 1e-9 m of an integrator with events. A mass at rest is pushed from the instant at which the wall overcomes its friction.
