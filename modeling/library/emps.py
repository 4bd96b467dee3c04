"""The EMPS of the public benchmark record of 2019: the paper's stage with a force offset.

[Janot2019]_: columns ``t, qg, qm, vir``, the control in volt. The control law was recovered from
the record. The true values of the twin are the published estimates.
"""

from axisid.control import cascade_pd_averaged
from axisid.elements import coulomb, offset, viscous
from axisid.modeling.declaration import Drive, Experiment, back_and_forth, newton
from axisid.modeling.quantities import Coordinate, Parameter

q = Coordinate("q", unit="m")
M = Parameter("M", "kg", nominal=100.0, lower=0.0, description="mass")
Fv = Parameter("Fv", "N/(m/s)", lower=0.0, description="viscous friction")
Fc = Parameter("Fc", "N", lower=0.0, description="Coulomb friction")
tau0 = Parameter("tau0", "N", description="offset")

axis = newton(
    "emps",
    title="EMPS, public benchmark record of 2019",
    coordinate=q,
    parameters=(M, Fv, Fc, tau0),
    inertia=M,
    resistance=(viscous(Fv, q), coulomb(Fc, q), offset(tau0)),
    drive=Drive(gain=35.15065188248547, unit="V", limit=10.0),
    control=cascade_pd_averaged(kp=160.18, kv=243.45, period=1e-3),
    columns={"time": "t", "position": "qm", "reference": "qg", "control": "vir"},
    experiment=Experiment(
        moves=back_and_forth(speeds=(0.04, 0.08, 0.12), acceleration=0.8, seconds=1.0, repeat=2),
        truth={"M": 95.1089, "Fv": 203.5034, "Fc": 20.3935, "tau0": -3.1648},
        position_noise=5e-8,
        seed=2019,
    ),
)
