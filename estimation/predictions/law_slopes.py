"""How the output of a simulated loop changes with a factor of each term of its law."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from axisid.estimation.loops import LawTicks, applied_terms, law_memory, state_at_rest
from axisid.estimation.simulation import simulate_lanes
from axisid.support.arrays import Array

from .added_slopes import injected_slopes
from .stretch import Stretch


def slopes_by_law(stretch: Stretch, own: Array, substeps: int | None) -> Mapping[str, Array]:
    """Slopes of a stretch's outputs, (n,), by the gains of the term.

    Parameters
    ----------
    stretch : Stretch
    own : (p,) array
        Parameters of its axis.
    substeps : int or None

    Returns
    -------
    mapping of str to (n,) array
        Empty of a continuous law, and where a loop cannot be simulated.
    """
    law, inputs = stretch.axis.axis.control, stretch.inputs
    if law is None or law.continuous:
        return {}
    alone = replace(inputs, clocks=None)
    wanted = ("position", "velocity")
    loop = simulate_lanes(stretch.axis, own[None, :], alone, substeps=substeps, wanted=wanted)
    if loop.failures:
        return {}
    position, velocity = (loop[name][:, 0] for name in wanted)
    ticks = LawTicks.at_samples(inputs.reference, position, velocity, inputs.signals)
    memory = inputs.start.memory
    # The loop's memory has the drive's behind the law's, whose terms do not depend on it.
    own_memory = None if memory is None else np.asarray(memory)[: law_memory(stretch.axis)]
    start = state_at_rest(stretch.axis, ticks) if own_memory is None else own_memory
    terms = applied_terms(stretch.axis, ticks, start)
    # They are those that are applied; what is injected is applied as late as they are.
    terms = np.vstack([terms[law.delay :], np.repeat(terms[-1:], law.delay, axis=0)])
    slopes = injected_slopes(stretch, own, substeps, terms)
    if slopes is None:
        return {}
    names = [str(product) for product, _ in law.terms]
    return dict(zip(names, slopes.T, strict=True))
