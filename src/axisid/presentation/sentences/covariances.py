"""Descriptions of standard errors: estimator, lags, corrections and simulated replicas."""

from collections.abc import Mapping

from axisid.estimation.regression import CovarianceNote
from axisid.support.mappings import grouped

from .words import listed, one_after_another

#: Names of covariances by kind, in full and in short.
_KINDS = {
    "classical": "i.i.d., residual variance with n - k",
    "robust": "heteroscedasticity-robust",
    "ar1": "AR(1) of the residuals",
}
_SHORT = {
    "published": "i.i.d.",
    "classical": "i.i.d.",
    "robust": "heteroscedasticity-robust",
    "hac": "HAC",
    "ar1": "AR(1) residuals",
}
#: Kinds of covariances that do not allow for autocorrelated residuals.
_IGNORE_AUTOCORRELATION = ("published", "classical", "robust")
_LAG_RULES = {
    "none": "no rule",
    "plug-in": "plug-in rule",
    "plug-in, capped": "plug-in rule, capped",
    "given": "as given",
}
_AT_LEAST_AR1 = "no smaller than for AR(1) residuals, because few scores are independent"


def covariance_text(note: CovarianceNote) -> str:
    """Return the description of a covariance: estimator, lags, corrections and replicas."""
    return _joined(_estimator(note), _calibration(note))


def shared_covariance_text(notes: Mapping[str, CovarianceNote]) -> str:
    """Return sentences on the covariances of several methods; the last has no full stop.

    They have the lags of all methods, and name the methods whose corrections or replicas differ.

    Parameters
    ----------
    notes : mapping of str to CovarianceNote
        Notes of one kind, by method.
    """
    first, *_ = notes.values()
    if first.kind == "hac":
        sentences = ["HAC, because residuals of filtered data are autocorrelated"]
        if first.is_prewhitened:
            sentences.append("The scores are prewhitened by AR(1)")
        sentences.append(f"The kernel is a Bartlett kernel with {_lags_by_method(notes)}")
        if first.is_corrected:
            sentences.append("The covariance is multiplied by n/(n - k)")
    else:
        allowed = ", which HAC allows for" if first.kind in _IGNORE_AUTOCORRELATION else ""
        sentences = [
            _estimator(first),
            f"Residuals of filtered data are autocorrelated{allowed}",
        ]
    by_method = grouped((_calibration_sentences(e), name.upper()) for name, e in notes.items())
    for texts, names in by_method.items():
        if len(by_method) == 1 or not texts:
            sentences += texts
        else:
            start, *others = texts
            sentences += [f"{', '.join(names)}: {start[:1].lower()}{start[1:]}", *others]
    return one_after_another(sentences)


def covariance_in_short(note: CovarianceNote) -> str:
    """Return the short description of a covariance: its name and its replicas, without lags."""
    name = _SHORT.get(note.kind, note.label)
    if note.replicas:
        records = "records" if len(note.noise) > 1 else "record"
        return f"{name}, calibrated with {note.replicas} simulated replicas of the {records}"
    if note.no_replicas:
        return f"{name}, without simulated replicas, because {note.no_replicas}"
    return name


def iid_text(note: CovarianceNote) -> str:
    """Return sentences on the standard error for independent residuals; the last has no full stop.

    Notes of files of earlier versions have no number of degrees of freedom.
    """
    if note.kind != "published":
        return covariance_text(note)
    return (
        "standard error for independent residuals. The residual variance is the sum of squares "
        f"divided by n - 1 = {note.degrees}, as in the tables of Brunot et al. (SYSID 2015)"
    )


def _lags_by_method(notes: Mapping[str, CovarianceNote]) -> str:
    """Return the numbers of lags with their rules, and with methods where the numbers differ."""
    by_method = grouped(
        (f"{note.lags} lags ({_LAG_RULES[note.lag_rule]})", name.upper())
        for name, note in notes.items()
    )
    if len(by_method) == 1:
        return next(iter(by_method))
    return ", ".join(f"{lags} for {listed(names)}" for lags, names in by_method.items())


def _calibration_sentences(note: CovarianceNote) -> tuple[str, ...]:
    """Return sentences on the corrections for few scores and by simulated replicas.

    If there are no replicas, they have the reason.
    """
    sentences = []
    if note.is_at_least_ar1:
        sentences.append(f"The standard errors are {_AT_LEAST_AR1}")
    if note.replicas:
        records = "records" if len(note.noise) > 1 else "record"
        sentences.append(
            f"The standard errors are calibrated with {note.replicas} simulated replicas of the "
            f"{records}"
        )
        if len(note.noise) == 1:
            sentences.append(f"The replicas have this noise: {note.noise[0]}")
        else:
            sentences += [
                f"The replicas of record {i} have this noise: {noise}"
                for i, noise in enumerate(note.noise, 1)
            ]
    if note.is_silent:
        sentences.append("The loop shows no noise")
    if note.no_replicas:
        sentences.append(
            "The standard errors are not calibrated with simulated replicas, because "
            f"{note.no_replicas}"
        )
    return tuple(sentences)


def _estimator(note: CovarianceNote) -> str:
    """Return the estimator of a covariance, with the lags of HAC."""
    if note.kind == "published":
        return f"i.i.d., residual variance with n - 1 = {note.degrees}"
    if note.kind == "hac":
        whitening = "scores prewhitened by AR(1), " if note.is_prewhitened else ""
        text = f"HAC, {whitening}Bartlett kernel, {note.lags} lags ({_LAG_RULES[note.lag_rule]})"
    else:
        text = _KINDS.get(note.kind, note.label)
    if note.is_corrected:
        text += ", times n/(n - k)"
    return text


def _calibration(note: CovarianceNote) -> str:
    """Return the corrections for few scores and by simulated replicas; empty for none.

    If there are no replicas, it has the reason.
    """
    parts = []
    if note.is_at_least_ar1:
        parts.append(_AT_LEAST_AR1)
    if note.replicas:
        noise_of_records = note.noise
        if len(note.noise) > 1:
            noise_of_records = tuple(
                f"record {i}: {noise}" for i, noise in enumerate(note.noise, 1)
            )
        parts.append(
            f"calibrated with {note.replicas} simulated replicas of the record with "
            f"{'; '.join(noise_of_records)}"
        )
    if note.is_silent:
        parts.append("the loop shows no noise")
    if note.no_replicas:
        parts.append(f"without simulated replicas: {note.no_replicas}")
    return "; ".join(parts)


def _joined(*parts: str) -> str:
    """Return the parts that are not empty, separated by semicolons."""
    return "; ".join(part for part in parts if part)
