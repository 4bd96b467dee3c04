"""Forms of the ready laws for the search, with a linear regression that gives start values.

A form is a ready law with some choice of its gains and options. The control of a form without an
integral or a filter is linear in products of its gains. With an integral, there are more products
than gains, which still give start values. A filter has a gain that is tried from a list.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from axisid.estimation.law_replay import LawInputs
from axisid.modeling.declaration import LAWS, ControlLaw
from axisid.support.arrays import Array

#: Start values of time constants and 1/bandwidths of a filter, sampling periods.
_FILTERS = (1.0, 1.5, 2.2, 3.3, 5.0, 7.5, 11.0, 17.0, 25.0)
#: Start values of the time of back-calculation, relative to the integral time.
_TRACKING = (0.3, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadyLaw:
    """A ready law without the values of its gains.

    Attributes
    ----------
    function : str
        Name of the function in `axisid.control` that makes the law, as in `LAWS`.
    words : mapping of str to str
        Arguments of that function that are not numbers, such as ``velocity="averaged"``.
    same : str
        Description of other laws with the same control; empty if there are none.
    """

    function: str
    words: Mapping[str, str] = field(default_factory=dict)
    same: str = ""

    @property
    def title(self) -> str:
        """Name of the law with its words: ``cascade_p_pi, velocity averaged``."""
        words = (f"{name.replace('_', ' ')} {value}" for name, value in self.words.items())
        return ", ".join([self.function, *words])


@dataclass(frozen=True, slots=True, kw_only=True)
class LawForm(ReadyLaw):
    """A ready law, and the linear regression that gives start values of its gains.

    Attributes
    ----------
    columns : tuple of str
        Names of the signals of the regression. The control is a linear combination of them; see
        `signals`.
    gains : callable
        Maps the coefficients of the columns, by name, to gains of the law, by name.
    extra : str
        Gain of a filter, which is not found by the regression but tried from a list:
        ``velocity_filter``, ``pll_bandwidth`` or ``filter_time``. Empty for a law without one.
    """

    columns: tuple[str, ...]
    gains: Callable[[Mapping[str, float]], dict[str, float]]
    extra: str = ""

    def made(self, gains: Mapping[str, float], period: float, delay: int) -> ControlLaw:
        """Return the control law with given gains, period in s, and delay in samples."""
        return replace(LAWS[self.function](**gains, **self.words, period=period), delay=delay)

    def wound_gains(self, gains: Mapping[str, float]) -> Iterator[Mapping[str, float]]:
        """Yield start values of the gains with each tried time of anti-windup.

        `gains` is yielded first. For a law with back-calculation, several values of its
        `tracking_time` follow.
        """
        yield gains
        if self.words.get("anti_windup") != "back_calculation":
            return
        for share in _TRACKING:
            integral = gains["tn"] if "tn" in gains else abs(_over(gains["kp"], gains["ki"]))
            yield {**gains, "tracking_time": share * integral}

    def begun(self, period: float) -> Sequence[float | None]:
        """Return the start values of the gain `extra`; a single None for a law without such a gain.

        `period` is the sampling period, s.
        """
        if not self.extra:
            return (None,)
        times = [period * each for each in _FILTERS]
        if self.extra == "pll_bandwidth":
            return [1 / time / 2 for time in times]
        return times

    def signals(self, ticks: LawInputs, period: float, extra: float | None) -> dict[str, Array]:
        """Return the columns of the regression by name, (N,) each, at the samples of a record.

        Parameters
        ----------
        ticks : LawInputs
            Inputs of the law at the samples; the velocity is that of an ideal sensor.
        period : float
            Sample period, s.
        extra : float or None
            Value of the gain `LawForm.extra` of the filter; None for a law without one.
        """
        error, rate = ticks.reference - ticks.position, _rate(ticks.reference, period)
        velocity = self._velocity(ticks, period, extra)
        time = extra if self.extra == "filter_time" else None
        signals = {
            "error": error,
            "velocity": velocity,
            "rate": rate,
            "acceleration": _rate(rate, period),
            "derivative": _smooth(_rate(error, period), period, time),
            "sum of error": _sum(error, period),
            "sum of velocity": _sum(velocity, period),
            "sum of rate": _sum(rate, period),
            "constant": np.ones_like(error),
        }
        return {name: signals[name] for name in self.columns}

    def _velocity(self, ticks: LawInputs, period: float, extra: float | None) -> Array:
        """Return the velocity as the law computes it from positions, (N,).

        The arguments are as in `signals`.
        """
        # The option of the law, or its function, determines how the law computes the velocity.
        how, position = self.words.get("velocity", "difference"), ticks.position
        if how == "ideal" or self.function == "cascade_pd":
            return ticks.velocity
        if how == "averaged" or self.function == "cascade_pd_averaged":
            before = np.concatenate([position[:1], position[:1], position[:-2]])
            return np.asarray((position - before) / (2 * period))
        # Time constant of the low-pass of the differences, if there is one.
        time = None
        if self.extra in ("velocity_filter", "filter_time"):
            time = extra
        if how == "pll" and extra:
            time = 2 / extra
        return _smooth(_rate(position, period), period, time)


def _rate(values: Array, period: float) -> Array:
    """Return backward differences over the period, (N,)."""
    return np.asarray(np.diff(values, prepend=values[0]) / period)


def _sum(values: Array, period: float) -> Array:
    """Return the sum of all earlier values times the period, (N,)."""
    return period * np.concatenate([[0.0], np.cumsum(values)[:-1]])


def _smooth(values: Array, period: float, time: float | None) -> Array:
    """Return values after the first-order low-pass of `low_pass`, (N,).

    `time` is its time constant, s; the values are unchanged for None or 0.
    """
    if not time:
        return values
    from scipy.signal import lfilter

    share = period / (period + time)
    return np.asarray(lfilter([share], [1.0, share - 1.0], values))


def _over(above: float, below: float) -> float:
    """Return a quotient; 0 for a denominator of 0."""
    return above / below if below else 0.0


def _cascade(c: Mapping[str, float]) -> dict[str, float]:
    """Return the gains of a position-velocity cascade from the coefficients of its columns."""
    kv = -c["velocity"]
    gains = {"kp": _over(c["error"], kv), "kv": kv}
    if "rate" in c:
        gains["velocity_feed_forward"] = _over(c["rate"], kv)
    if "acceleration" in c:
        gains["acceleration_feed_forward"] = c["acceleration"]
    if "sum of error" in c:
        gains["tn"] = abs(_over(c["error"], c["sum of error"])) or 1.0
    return gains


def _pid(c: Mapping[str, float]) -> dict[str, float]:
    """Return the gains of a PD or PID law from the coefficients of its columns."""
    found = {"kp": c["error"], "kd": c.get("derivative", -c.get("velocity", 0.0))}
    if "sum of error" in c:
        found["ki"] = c["sum of error"]
    return found


_PD = ("error", "velocity")
_PI = (*_PD, "sum of error", "sum of velocity", "constant")
_AHEAD = ("rate", "sum of rate")
_PID = ("error", "derivative", "sum of error", "constant")


def _p_pi(velocity: str, *columns: str, extra: str = "") -> LawForm:
    """Return the form of a P-PI cascade.

    Parameters
    ----------
    velocity : str
        Value of the argument `velocity` of `cascade_p_pi`, ``difference``, ``averaged`` or ``pll``:
        how the law computes the velocity from positions. It is the only entry of `words`.
    *columns : str
        Names of the signals whose linear combination is the control, see `LawForm.signals`.
    extra : str
        Gain of the filter of the velocity, ``velocity_filter`` or ``pll_bandwidth``. The search
        tries a list of values for it. Empty for a law without a filter.
    """
    return LawForm(
        function="cascade_p_pi",
        columns=columns,
        gains=_cascade,
        words={"velocity": velocity},
        extra=extra,
    )


#: Forms of the search, those with few gains first.
FORMS: tuple[LawForm, ...] = (
    LawForm(
        function="cascade_pd_difference",
        columns=_PD,
        gains=_cascade,
        same="state_feedback with k_position = kp kv and k_velocity = kv",
    ),
    LawForm(function="cascade_pd_averaged", columns=_PD, gains=_cascade),
    LawForm(function="cascade_pd", columns=_PD, gains=_cascade),
    LawForm(
        function="impedance",
        columns=("error", "derivative"),
        gains=_pid,
        same="pid with ki = 0",
    ),
    *(_p_pi(how, *_PI) for how in ("difference", "averaged")),
    *(_p_pi(how, *_PD, "rate") for how in ("difference", "averaged")),
    LawForm(
        function="pid",
        columns=_PID,
        gains=_pid,
        same="pid_ideal with k = kp, ti = kp / ki, td = kd / kp, and dynamixel_position with its "
        "registers times their factors",
    ),
    LawForm(
        function="pid",
        columns=("error", "velocity", "sum of error", "constant"),
        gains=_pid,
        words={"derivative_of": "position"},
        same="state_feedback with k_position = kp, k_velocity = kd and k_integral = ki",
    ),
    *(_p_pi(how, *_PI, *_AHEAD) for how in ("difference", "averaged")),
    *(_p_pi(how, *_PI, *_AHEAD, "acceleration") for how in ("difference", "averaged")),
    LawForm(
        function="pid",
        columns=_PID,
        gains=_pid,
        extra="filter_time",
        same="pid_ideal with k = kp, ti = kp / ki, td = kd / kp and the same filter_time",
    ),
    LawForm(
        function="pid",
        columns=("error", "velocity", "sum of error", "constant"),
        gains=_pid,
        extra="filter_time",
        words={"derivative_of": "position"},
    ),
    _p_pi("difference", *_PI, extra="velocity_filter"),
    _p_pi("pll", *_PI, extra="pll_bandwidth"),
    _p_pi("difference", *_PI, *_AHEAD, extra="velocity_filter"),
    _p_pi("pll", *_PI, *_AHEAD, extra="pll_bandwidth"),
)
