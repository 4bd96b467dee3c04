"""A study as plain data."""

from axisid.estimation.monte_carlo import (
    CheckFigures,
    EstimandFigures,
    Mean,
    MonteCarlo,
    Share,
    declared_figures,
)
from axisid.estimation.twins import Chain
from axisid.presentation.documents import written_as, written_request
from axisid.presentation.saved import SavedMonteCarlo
from axisid.presentation.schema import (
    WrittenCheckFigures,
    WrittenEstimand,
    WrittenFailedRun,
    WrittenLevels,
    WrittenMean,
    WrittenMonteCarlo,
    WrittenShare,
    WrittenTwins,
)
from axisid.support.arrays import finite


def written_study(result: MonteCarlo) -> WrittenMonteCarlo:
    """What ``--json`` writes."""
    plan = result.plan
    experiment = Chain.of_experiment(plan.twin.axis)
    return WrittenMonteCarlo(
        belief=result.belief,
        axis=plan.axis.axis.name,
        signature=plan.axis.signature,
        twins=WrittenTwins(
            axis=plan.twin.axis.name,
            signature=plan.twin.signature,
            right=plan.is_right,
            noise=declared_figures(plan.noise),
            chain=plan.noise,
            position_noise=experiment.position,
            resolution=experiment.position_step,
            unit=plan.twin.axis.coordinate.unit,
            drive_unit=plan.twin.axis.drive.unit,
        ),
        runs=plan.runs,
        done=len(result),
        seed=plan.seed,
        methods=plan.methods,
        prefilter=written_request(plan.prefilter),
        settings=dict(plan.settings),
        levels=written_as(WrittenLevels, plan.levels),
        estimands=tuple(map(_estimand, result.figures)),
        judged=result.judged,
        objected=_share(result.objected),
        checks=tuple(map(_check, result.check_figures)),
        failures=tuple(
            WrittenFailedRun(run=each.run, of=each.of, reason=each.reason)
            for each in result.failures
        ),
    )


def study_facts(result: MonteCarlo) -> SavedMonteCarlo:
    """What a study tells without the numbers of its runs, which is all that tables show."""
    return SavedMonteCarlo(file="", document=written_study(result))


def _estimand(each: EstimandFigures) -> WrittenEstimand:
    estimand = each.estimand
    return WrittenEstimand(
        method=estimand.method,
        name=estimand.name,
        kind=estimand.kind,
        unit=estimand.unit,
        truth=finite(each.truth),
        runs=each.runs,
        bias=_mean(each.bias),
        raw_bias=_mean(each.raw_bias),
        scatter=_mean(each.scatter),
        deviations=dict(each.deviations),
        coverage={of: _share(share) for of, share in each.coverage.items()},
    )


def _check(check: CheckFigures) -> WrittenCheckFigures:
    return WrittenCheckFigures(
        name=check.name,
        fails=_share(check.fails),
        notes=_share(check.notes),
        passes=_share(check.passes),
        not_evaluated=_share(check.missing),
    )


def _mean(mean: Mean) -> WrittenMean:
    return WrittenMean(value=finite(mean.value), error=finite(mean.error))


def _share(share: Share) -> WrittenShare:
    return WrittenShare(count=share.count, of=share.of, interval_95=share.interval)
