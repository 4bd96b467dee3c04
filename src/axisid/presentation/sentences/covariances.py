"""Descriptions of standard errors: estimator, lags, corrections and simulated replicas."""

from collections.abc import Iterable, Mapping

from axisid.estimation.regression import CovarianceNote
from axisid.support.mappings import grouped

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
_LAG_RULES = {
    "none": "no rule",
    "plug-in": "plug-in rule",
    "plug-in, capped": "plug-in rule, capped",
    "given": "as given",
}
_AT_LEAST_AR1 = "no smaller than for AR(1) residuals, because few scores are independent"


def covariance_text(note: CovarianceNote) -> str:
    """Return the description of a covariance: estimator, lags, corrections and replicas."""
    return _joined(_estimator(note, [note]), _calibration(note))


def shared_covariance_text(notes: Mapping[str, CovarianceNote]) -> str:
    """Return one description for the covariances of several methods.

    It lists the lags of all methods, and names the methods whose corrections or replicas differ.

    Parameters
    ----------
    notes : mapping of str to CovarianceNote
        Notes of one kind, by method.
    """
    every = [*notes.values()]
    start = _estimator(every[0], every)
    by_method = grouped((_calibration(note), name.upper()) for name, note in notes.items())
    if len(by_method) == 1:
        return _joined(start, *by_method)
    parts = [f"{text} ({', '.join(names)})" for text, names in by_method.items() if text]
    return "; ".join([start, *parts])


def covariance_in_short(note: CovarianceNote) -> str:
    """Return the short description of a covariance: its name and its replicas, without lags."""
    name = _SHORT.get(note.kind, note.label)
    if note.replicas:
        records = "records" if len(note.noise) > 1 else "record"
        return f"{name}, calibrated with {note.replicas} simulated replicas of the {records}"
    if note.no_replicas:
        return f"{name}, without simulated replicas: {note.no_replicas}"
    return name


def _estimator(note: CovarianceNote, every: Iterable[CovarianceNote]) -> str:
    """Return the estimator of a covariance; HAC has the different lags of all notes `every`."""
    if note.kind == "published":
        return f"i.i.d., residual variance with n - 1 = {note.degrees}"
    if note.kind == "hac":
        lags = ", ".join(dict.fromkeys(str(each.lags) for each in every))
        whitening = "scores prewhitened by AR(1), " if note.is_prewhitened else ""
        text = f"HAC, {whitening}Bartlett kernel, {lags} lags ({_LAG_RULES[note.lag_rule]})"
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
