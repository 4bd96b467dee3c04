# %% [markdown]
# # Recorded signals in the model
#
# A column of the log that is not a motion of this axis can be part of the equation of motion, the drive or the
# control law. Examples are a pressure, a temperature, a supply voltage, the acceleration of another axis, or a
# feed-forward of a machine's controller. Such a column is a `Signal`. It has a name, a unit and an interpolation between
# the samples of a log: `"linear"` (default), or `"held"` for a value that a controller outputs once per sample.
#
# The example is a vertical axis with a pneumatic counterbalance. Its pressure swings as the slide moves. The area on
# which the pressure acts is a parameter. It can be separated from the constant load because the pressure varies:

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
# `Experiment(signals=...)` defines the signals of the twin over time. `simulate`, `simulate_batch` and `twin_record`
# take arrays by name, `signals={"pressure": values}`, with one value for each sample of the reference.
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
# In a log, each signal is a column like any other. Name it by `[columns]` or `--columns pressure=p:bar`; otherwise its own
# name is used. It has a unit or a scaling, and is shifted, windowed and resampled. A log without it is refused.
#
# ## Where a signal can be used
#
# | place | use |
# |---|---|
# | equation of motion | any expression with the motion and the parameters: `-area*pressure`, `k*temperature*dq`, `m*other_ddq` |
# | drive | `scaled_by`, a factor of the gain made of signals and constants; `profile`; the force of your own drive class |
# | control law | its output and its memory: a feed-forward, a commanded velocity |
#
# Signals vary independently, so products of a parameter and a signal are separate base parameters. An inertia with a
# signal in it has no direct regressor and no Lagrangian, because its rate of change is not recorded.
#
# ## How a signal is processed
#
# **Rows.** A signal is treated like the force: as recorded, without the low-pass, because it is not differentiated.
# Products with the motion are computed sample by sample. Then both sides pass the same decimation filter. For a held
# signal, the row has the mean of the values before and after the sample, which matches the acceleration.
#
# **Check.** `recorded signals` compares each signal with its force. If a column was logged late or early, the check
# reports its delay and the `shift` that corrects it. If a column has another unit (bar read as Pa), the check reports the
# factor, provided that the signal's coefficient is known. An estimated coefficient absorbs the factor; then the verdict says that
# the scale of the signal depends only on its column and unit. The library has such an axis, `balanced_slide`.
#
# **Simulation.** Between samples the plant uses the signal as declared, so an axis that sticks starts to move
# within a sample, when a linear signal overcomes its friction. A sampled law and its drive read the signal when the law is
# evaluated; then the force is held. If the log is slower or faster than the law, the signal is interpolated. If the
# *position* of a contact moves with a signal (`Max(0, q - wall)`), or a signal crosses a threshold (`Piecewise` over a
# temperature), the crossing is located within the sample. A mass of 2 kg against a moving wall of 2e4 and 3e6 N/m at 1 kHz
# is within 1e-9 m of an integrator with events. A mass at rest is pushed from the instant at which the wall overcomes
# its friction.
