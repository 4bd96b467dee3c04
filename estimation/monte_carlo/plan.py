"""What is done in every run: which twin is made, and how it is identified."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from axisid.codegen.artefacts import GeneratedAxis, build
from axisid.estimation.checks import DEFAULT_LEVELS, Levels
from axisid.estimation.choices import check_among, fit_names, fitted_output
from axisid.estimation.signals import Prefilter
from axisid.estimation.simulation import twin_plan
from axisid.estimation.twins import Autoregressions, Chain
from axisid.modeling.declaration import Experiment, Move
from axisid.support.errors import ModelError, UsageError
from axisid.support.mappings import FrozenMapping
from axisid.support.real_numbers import is_real, is_whole
from axisid.support.user_values import quoted

#: What the intervals of a fit are of: errors that follow an autoregression.
COLOURED, IID = "coloured", "iid"
_MOST_RUNS = 10_000_000  # whose numbers a study holds together


@dataclass(frozen=True, slots=True, kw_only=True)
class MonteCarloPlan:
    """What is done in every run.

    Attributes
    ----------
    axis : GeneratedAxis
        That is identified.
    twin : GeneratedAxis
        That is simulated; the same, unless the model is to be wrong.
    runs : int
    seed : int
    methods : tuple of str
        Of `METHODS`, and fits such as ``fit:control``.
    noise : Chain
    prefilter : Prefilter
        What it leaves open is chosen for the twins' rate.
    checks : int
        How many runs are judged, from the first on.
    settings : mapping of str to object
        What else `identify` takes: ``covariance``, ``lags``, ``start``, ``loss``, which are nothing
        to fits.
    bootstrap : int
        How many twins tell the bias and HAC deviations of an estimate; 0 for none.
    levels : Levels
        By which runs are judged.
    """

    axis: GeneratedAxis
    twin: GeneratedAxis
    runs: int
    seed: int
    methods: tuple[str, ...]
    noise: Chain
    prefilter: Prefilter
    checks: int
    settings: Mapping[str, Any]
    bootstrap: int = 0
    levels: Levels = DEFAULT_LEVELS

    def __post_init__(self) -> None:
        _check_count("runs", self.runs, least=1)
        if self.runs > _MOST_RUNS:
            raise UsageError(
                f"the runs of a Monte-Carlo study are {quoted(self.runs)}, whose numbers "
                f"would be in memory together; give at most {_MOST_RUNS:,}.",
                code="monte-carlo-runs",
            )
        _check_count("seed", self.seed, least=0)
        _check_count("checks", self.checks, least=0)
        object.__setattr__(self, "settings", FrozenMapping(self.settings))

    @property
    def is_right(self) -> bool:
        """Whether what is identified is what is simulated, what is known exactly included."""
        if self.axis.signature != self.twin.signature:
            return False
        true = twin_plan(self.twin).true_values
        return all(
            math.isclose(p.known, true.get(p.name, p.known))
            for p in self.axis.base.known
            if p.known is not None and not p.known_sd
        )

    @property
    def regressions(self) -> tuple[str, ...]:
        """The methods of `identify`."""
        return tuple(method for method in self.methods if not fitted_output(method))

    @property
    def fits(self) -> tuple[str, ...]:
        """The methods that are fits of the output error."""
        return tuple(filter(fitted_output, self.methods))

    @property
    def chosen(self) -> str:
        """Of `COVARIANCES`, what printed intervals are of; those of fits see `stated_by`."""
        return str(self.settings["covariance"])


def stated_by(method: str, chosen: str) -> str:
    """What the printed intervals of a method are of: those of identifications are chosen."""
    return COLOURED if fitted_output(method) else chosen


def split_methods(methods: tuple[object, ...]) -> tuple[list[object], list[str]]:
    """Methods of `identify`, unchecked, and fits.

    Raises
    ------
    UsageError
        There is no fit of such an output.
    """
    fits = [each for each in methods if isinstance(each, str) and fitted_output(each)]
    check_among(*(("fit", each, fit_names()) for each in fits))
    return [each for each in methods if each not in fits], fits


def noise_of(given: object, twin: GeneratedAxis) -> Chain:
    """The noise of an axis's twins, the experiment's where none is given.

    Raises
    ------
    UsageError
        It is none, it begins anywhere in a count and the encoder has none, or it is beside the law
        or not sampled evenly, which no twin of an experiment is.
    ModelError
        It disturbs what is logged.
    """
    name = twin.axis.name
    noise = Chain.of_experiment(twin.axis) if given is None else given
    if not isinstance(noise, Chain):
        raise UsageError(
            f"the noise is {quoted(noise)}; give a Chain, or leave it out.",
            code="twin-noise-type",
        )
    if noise.jitter or not noise.is_measured_by_law:
        raise UsageError(
            f"the twins of {name!r} are sampled evenly and their law measures the logged position; "
            "give noise without jitter, with is_measured_by_law=True.",
            code="twin-sampling",
        )
    if noise.disturbances and twin.axis.drive.logs_what_acts:
        raise ModelError(
            f"the twins of {name!r} log what acts, which a disturbance is part of; leave it out, "
            "or declare a drive that logs its command.",
            code="twin-disturbance",
        )
    if noise.anywhere and not noise.position_step:
        raise UsageError(
            f"the twins of {name!r} are to begin anywhere in a count, and their encoder has none; "
            "give its resolution, or leave it out.",
            code="twin-anywhere",
        )
    return noise.likeliest


def declared_chain(
    chain: Chain,
    *,
    position: float | None = None,
    resolution: float | None = None,
    anywhere: bool = False,
    velocity: float | None = None,
    acceleration: float | None = None,
    control: float | None = None,
    disturbance: float | None = None,
    correlation_time: float | None = None,
) -> Chain:
    """A chain with what is given.

    Parameters
    ----------
    chain : Chain
        The experiment's, as `Chain.of_experiment` has it.
    position, resolution : float, optional
        Of the encoder, in the coordinate's unit; the chain's by default.
    anywhere, velocity, acceleration
        As of a `Chain`.
    control, disturbance : float, optional
        In the drive's unit; none by default.
    correlation_time : float, optional
        Of both, s; white by default.
    """

    def coloured(deviation: float | None) -> Autoregressions:
        return ((correlation_time or 0.0, deviation),) if deviation else ()

    return replace(
        chain,
        position=chain.position if position is None else position,
        position_step=chain.position_step if resolution is None else resolution,
        anywhere=anywhere,
        velocity=velocity,
        acceleration=acceleration,
        control=coloured(control),
        disturbances=coloured(disturbance),
    )


def declared_figures(chain: Chain) -> dict[str, float | bool | None]:
    """The figures of a chain by these names: of several autoregressions their sum's deviation."""
    control, disturbance = (
        math.hypot(*(sd for _, sd in parts)) for parts in (chain.control, chain.disturbances)
    )
    return {
        "position": chain.position,
        "resolution": chain.position_step,
        "anywhere": chain.anywhere,
        "velocity": chain.velocity,
        "acceleration": chain.acceleration,
        "control": control,
        "disturbance": disturbance,
        "correlation_time": max(
            (time for time, _ in (*chain.control, *chain.disturbances)), default=0.0
        ),
    }


def twin_of(
    axis: GeneratedAxis, truth: Mapping[str, float], moves: tuple[Move, ...] | None
) -> GeneratedAxis:
    """The axis with other true values, or another experiment.

    Raises
    ------
    UsageError
        A value is of no parameter, or none.
    """
    if not isinstance(truth, Mapping):
        raise UsageError(
            f"the true values are {quoted(truth)}; give a mapping of names to numbers, SI.",
            code="study-truth-type",
        )
    if not truth and moves is None:
        return axis
    declared = axis.declared
    names = {p.name for p in declared.parameters}
    for name, value in truth.items():
        if name not in names:
            raise UsageError(
                f"axis {declared.name!r} declares no parameter {quoted(name)}; its parameters are "
                f"{', '.join(sorted(names))}.",
                code="unknown-truth",
            )
        if not is_real(value):
            raise UsageError(
                f"the true {name} is {quoted(value)}; give a number, SI.", code="bad-truth"
            )
    experiment = declared.experiment
    if experiment is None and moves is None:
        return axis  # which then is refused as a twin
    given = Experiment(moves=moves or ()) if experiment is None else experiment
    changed = replace(given, moves=given.moves if moves is None else moves)
    changed = replace(changed, truth={**changed.truth, **truth})
    return build(replace(declared, experiment=changed), native=axis.native.enabled)


def _check_count(what: str, value: object, *, least: int) -> None:
    if not (is_whole(value) and value >= least):
        raise UsageError(
            f"the {what} of a Monte-Carlo study {'is' if what == 'seed' else 'are'} "
            f"{quoted(value)}; give a whole number of {least} or more.",
            code="monte-carlo-count",
        )
