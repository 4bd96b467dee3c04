"""How often 95 % intervals hold the truth: classical and autocorrelation-consistent ones.

The motion is three times that of the paper's twin, without position noise; the force carries either
white noise or a ripple whose correlation dies out over 50 ms (first-order autoregressive). Every
run is a whole IDM-LS fit: the force is decimated with the regressor, 1 of 10, and both intervals
are formed with Student's distribution. Decimation colours white noise a little. The seed is fixed.

    python benchmarks/calibration.py            a table
    python benchmarks/calibration.py --json -   one JSON object
"""

import math

import numpy as np
from figures import give, parser_of
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.special import stdtrit

from axisid import Prefilter, build, load_axis, simulate
from axisid.estimation.regression.covariance import Covariance, Hac, PublishedCovariance
from axisid.estimation.regression.forms import InverseForm
from axisid.estimation.regression.linear import factor, least_squares
from axisid.estimation.signals import SampledFilter
from axisid.estimation.simulation.twin import trajectory

Array = NDArray[np.float64]

PERIOD, NOISE, CORRELATION_TIME = 1e-3, 5.0, 0.05  # s, N, s
REPEATED = 3  # times the motion of the twin: as long as the EMPS record
TRUTH = np.array([100.2, 236.9, 24.8])
FILTER = SampledFilter(Prefilter(cutoff=60.0, decimate=10, drop=(50, 50)), PERIOD)
INTERVALS: dict[str, Covariance] = {"iid": PublishedCovariance(), "hac": Hac()}


def noise(rng: np.random.Generator, samples: int, *, coloured: bool) -> Array:
    """Noise of the force, N: white, or correlated over 50 ms, of the same deviation."""
    white = rng.normal(size=samples)
    if not coloured:
        return NOISE * white
    pole = math.exp(-PERIOD / CORRELATION_TIME)
    settled = lfilter([math.sqrt(1 - pole**2)], [1, -pole], rng.normal(size=samples + 1000))
    return NOISE * np.asarray(settled[1000:], dtype=float)


def coverage(runs: int, seed: int = 1) -> dict[str, dict[str, float]]:
    """Share of runs whose interval holds the truth, by noise and interval, then by parameter."""
    axis = build(load_axis("emps2015"))
    if axis.axis.experiment is None:
        raise SystemExit("the axis has no experiment")
    reference = trajectory(REPEATED * axis.axis.experiment.moves, PERIOD)
    loop = simulate(axis, TRUTH, reference, PERIOD)
    row = InverseForm(axis).equations(loop.signals).regressor
    regressor = factor(FILTER.reduce(row), axis.names)
    n, k = regressor.columns.shape
    reach = float(stdtrit(n - k, 0.975))
    rng = np.random.default_rng(seed)
    hits = {f"{c}_{i}": np.zeros(k) for c in ("white", "coloured") for i in INTERVALS}
    for _ in range(runs):
        for colour in ("white", "coloured"):
            force = row @ TRUTH + noise(rng, len(row), coloured=colour == "coloured")
            solution = least_squares(FILTER.reduce(force), regressor)
            for name, covariance in INTERVALS.items():
                sd = np.sqrt(np.diag(covariance.matrix(solution)))
                hits[f"{colour}_{name}"] += np.abs(solution.theta - TRUTH) <= reach * sd
    return {
        name: dict(zip(axis.names, (count / runs).tolist(), strict=True))
        for name, count in hits.items()
    }


def main() -> None:
    """Print the table, or write the JSON object."""
    parser = parser_of(__doc__)
    parser.add_argument("--runs", type=int, default=2000, help="repetitions (default 2000)")
    options = parser.parse_args()
    figures = coverage(options.runs)
    lines = [f"share of {options.runs} 95 % intervals that hold the truth"]
    for name, shares in figures.items():
        listed = "  ".join(f"{p} {100 * share:5.1f} %" for p, share in shares.items())
        lines.append(f"{name:<14}{listed}")
    give({**figures, "runs": options.runs}, options.json, lines)


if __name__ == "__main__":
    main()
