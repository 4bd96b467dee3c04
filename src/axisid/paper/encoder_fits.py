"""The paper's encoders once more, by a fit of the control (CLIE), which passes no filter."""

from axisid.codegen.artefacts import GeneratedAxis
from axisid.estimation.choices import CONTROL
from axisid.estimation.fitting import OutputFit, fit
from axisid.estimation.monte_carlo import MonteCarloPlan, twins
from axisid.estimation.records import Record
from axisid.estimation.signals import Prefilter
from axisid.estimation.twins import Chain
from axisid.support.errors import EstimationError


def control_fits(axis: GeneratedAxis, noise: Chain, runs: int, seed: int) -> list[OutputFit]:
    """The fits of the twins that `monte_carlo` makes of a noise and a seed, where there is one.

    Parameters
    ----------
    axis : GeneratedAxis
    noise : Chain
    runs, seed : int
    """
    plan = MonteCarloPlan(
        axis=axis,
        twin=axis,
        runs=runs,
        seed=seed,
        methods=(),
        noise=noise,
        prefilter=Prefilter(),
        checks=0,
        settings={},
    )
    found = []
    for _, twin in twins(plan, range(runs)):
        if isinstance(twin, Record):
            try:
                found.append(fit(axis, twin, output=CONTROL))
            except EstimationError:  # counted as a twin without an estimate
                continue
    return found
