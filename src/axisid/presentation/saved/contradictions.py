"""What a file may hold by its schema, and a result or the drive of an axis cannot be."""

import math
import sys
from collections.abc import Iterator, Mapping, Sequence

from axisid.estimation.estimates import COVARIANCES
from axisid.estimation.methods import METHODS
from axisid.modeling.declaration import Axis, CommandPath, Drive
from axisid.presentation.schema import (
    Matrix,
    WrittenDriveTime,
    WrittenEstimate,
    WrittenIdentification,
    WrittenPrefilter,
    WrittenRecord,
    WrittenResponse,
    WrittenValue,
    plain,
)
from axisid.support.errors import DataError, ModelError, UsageError
from axisid.support.files.result_file import WRITE_AGAIN
from axisid.support.user_values import quoted

from .estimate import (
    written_covariances,
    written_ddm_covariances,
    written_deviations,
    written_physical_covariances,
)

_SAME_DEVIATION = 1e-9  # relative, of two deviations that went through a text
_SAME = 1e-6  # relative, of a variance and a deviation: writing and reading change neither
_NOTHING = 1e-300  # a variance whose root squared loses digits


def written_drive(written: WrittenResponse) -> Drive:
    """A drive of a gain of 1 that follows its commands as a file says; its times are numbers."""
    told = plain(written)
    told.pop("estimated", None)
    return Drive(gain=1.0, **told)


def refuse_other_drive(document: WrittenIdentification, file: str, axis: Axis) -> None:
    """Refuse an axis whose drive differs from the identified one where no code tells them apart.

    Parameters
    ----------
    document : WrittenIdentification
    file : str
    axis : Axis
        As it was given, a time of its drive that is estimated still a parameter.

    Raises
    ------
    UsageError
        It has another lag, delay, place of the recorded control, or deviation of its gain.
    """
    for name, then, now in _differences(document, axis.drive):
        raise UsageError(
            f"{file} was identified with the drive's {name} {then}, but {axis.name!r} as it is "
            f"declared now has {now}; give the axis as it was then, or identify again.",
            code="other-saved-drive",
        )


def _differences(document: WrittenIdentification, drive: Drive) -> Iterator[tuple[str, str, str]]:
    """What differs, as it was and as it is."""
    written = document.drive if isinstance(document.drive, WrittenResponse) else None
    then = Drive(gain=1.0) if written is None else written_drive(written)
    found = None if written is None else written.estimated
    if isinstance(found, WrittenDriveTime):
        start = float(getattr(drive, found.of))
        if start not in (found.nominal, found.value):
            yield found.of, f"estimated from {found.nominal:g}", f"{start:g}"
        drive = drive.with_time(found.of, found.value)
    elif drive.estimated is not None:
        name = drive.estimated[0]
        yield name, f"{getattr(then, name):g}", "it to be estimated"
    for name in ("lag", "delay", "logged", *CommandPath.__dataclass_fields__):
        old, new = getattr(then, name), getattr(drive, name)
        if old != new:
            yield name, str(old), str(new)
    spread = document.estimates[0].gain_relative_sd  # 0 too where the force was measured
    if spread and not math.isclose(spread, drive.relative_sd, rel_tol=_SAME_DEVIATION):
        yield "relative_sd", f"{spread:g}", f"{drive.relative_sd:g}"


def refuse_contradictions(document: WrittenIdentification, file: str) -> None:
    """Refuse a file whose members do not belong together.

    Raises
    ------
    DataError
    """
    _refuse_unknown(document, file)
    if problem := next(_identified(document), ""):
        raise contradiction(file, problem)


def _refuse_unknown(document: WrittenIdentification, file: str) -> None:
    """Refuse a file of a program that has a covariance more: it may well be whole."""
    for estimate in document.estimates:
        if estimate.chosen_covariance not in COVARIANCES:
            raise DataError(
                f"{file} has intervals by the covariance {quoted(estimate.chosen_covariance)}, "
                f"which this program does not have (it has {', '.join(COVARIANCES)}); "
                "register it as the program did that wrote the file, or identify again.",
                code="unknown-saved-covariance",
            )


def contradiction(file: str, problem: str) -> DataError:
    """The refusal of a file, with what is wrong with it and what to do."""
    return DataError(
        f"{file} contradicts itself: {problem}. ", WRITE_AGAIN, code="contradictory-result"
    )


def true_of(said: Mapping[str, bool]) -> list[str]:
    """Those of several sentences that are true."""
    return [sentence for sentence, is_true in said.items() if is_true]


def _identified(document: WrittenIdentification) -> Iterator[str]:
    methods = [estimate.method for estimate in document.estimates]
    yield from true_of(
        {
            f"there is no {document.judged!r}": document.judged not in methods,
            "it has two estimates of one method": len({*methods}) != len(methods),
        }
    )
    for estimate in document.estimates:
        yield from _estimate(estimate)
        if not document.records:
            yield from _record(document.record, document.prefilter, estimate.rows)
        elif estimate.rows != sum(member.rows for member in document.records):
            yield f"the rows of {estimate.method} are not those of its records"
    if isinstance(drive := document.drive, WrittenResponse):
        try:
            written_drive(drive)
        except ModelError as error:
            yield f"its drive cannot be: {error}"
    yield from _several(document)
    yield from _samples(document.record)


def _samples(record: WrittenRecord) -> Iterator[str]:
    """How many there are, and which of them are told of."""
    if not 0 < record.samples <= sys.maxsize:
        yield f"its record has {record.samples} samples"
    for first, end in (*record.segments, *record.masked):
        if not 0 <= first < end <= record.samples:
            yield f"the rows {first} to {end} are not of its {record.samples} samples"


def _several(document: WrittenIdentification) -> Iterator[str]:
    """Several records, each with rows of its own samples."""
    members, names = document.records or (), {*document.estimates[0].parameters}
    for member in members:
        yield from _record(member.record, member.prefilter, member.rows)
        if member.weight <= 0 or member.noise < 0:
            yield f"the weight or the noise of {member.name} is negative"
    for name, own in (document.local or {}).items():
        if len(own) != len(members) or {*own} - names - {""}:
            yield f"the values of {name} by record are not among its parameters"
    if document.declared_gain and "drive_gain" not in names:
        yield "it has a declared drive gain beside none that is identified"


def _record(record: WrittenRecord, prefilter: WrittenPrefilter, rows: int) -> Iterator[str]:
    samples, period, silent = record.samples, record.sample_period, prefilter.silent
    dropped = f"of {samples} samples it drops {prefilter.drop} and {silent} at reversals"
    yield from true_of(
        {
            f"the sample period is {period:g} s": period <= 0,
            f"there are {rows} rows of {samples} samples": rows > samples,
            dropped: min(*prefilter.drop, silent) < 0 or silent > samples,
        }
    )


def _estimate(of: WrittenEstimate) -> Iterator[str]:
    covariances, count = written_covariances(of), len(of.parameters)
    each = (*covariances.values(), of.correlation)
    sizes = [size or 0.0 for size in (of.simulation_error_percent, *of.curvatures.values())]
    regressed = len(of.parameters if of.theta_ddm is None else of.theta_ddm)
    yield from true_of(
        {
            f"there is no method {of.method!r}": of.method not in METHODS,
            f"there is no covariance {of.chosen_covariance!r}": of.chosen_covariance
            not in covariances,
            f"the covariances of {of.method} are not of its {count} parameters": any(
                len(covariance) != count for covariance in each
            ),
            f"an error or a curvature of {of.method} is negative": min(
                of.equation_error_percent, *sizes
            )
            < 0,
            f"{of.method} has {of.rows} rows for {regressed} parameters": of.rows <= regressed,
        }
    )
    yield from _values(of.parameters, covariances, of.method)
    for check in (_direct, _gain, _iterations):
        yield from check(of)
    if of.physical:
        covariances = written_physical_covariances(of.physical)
        yield from _values(of.physical.parameters, covariances, of.method)


def _direct(of: WrittenEstimate) -> Iterator[str]:
    """Of the direct model's parameters, which have covariances of their own."""
    always = (of.theta_ddm_covariance, of.theta_ddm_covariance_hac)
    if any((matrix is None) != (of.theta_ddm is None) for matrix in always):
        yield f"the direct model's parameters of {of.method} and their covariances are not of one"
    yield from _values(of.theta_ddm or {}, written_ddm_covariances(of), of.method)


def _gain(of: WrittenEstimate) -> Iterator[str]:
    """What the drive gain's deviation adds, against the slopes by the gain."""
    if not 0 <= of.gain_relative_sd < 1:
        yield f"the drive gain of {of.method} has the relative deviation {of.gain_relative_sd:g}"
    for values, slopes in (
        (of.parameters, of.gain_slopes),
        (of.theta_ddm or {}, of.theta_ddm_gain_slopes),
    ):
        if slopes is not None and {*slopes} != {*values}:
            yield f"the slopes by the drive gain of {of.method} are of other parameters"
            return
        for name, value in values.items():
            moved = of.gain_relative_sd * abs(slopes[name]) if slopes else 0.0
            if not _same(value.sd_gain, moved):
                yield f"what the drive gain adds to {name} by {of.method} is not of its slope"


def _iterations(of: WrittenEstimate) -> Iterator[str]:
    names, direct = {*of.parameters}, {*(of.theta_ddm or {})}
    own, alike = (of.curvatures, *of.iterations), of.theta_ddm_iterations or ()
    counts = {len(of.iterations), len(of.iteration_simulation_errors_percent)}
    counts |= {len(alike)} if of.theta_ddm_iterations is not None else set()
    yield from true_of(
        {
            f"the iterations, curvatures or draws of {of.method} are of other parameters": bool(
                any({*each} != names for each in own) or {*(of.drawn or {})} - names
            ),
            f"the iterations of {of.method} are of other parameters of the direct model": any(
                {*each} != direct for each in alike
            ),
            f"the iterations of {of.method} have errors of other ones": len(counts) > 1,
        }
    )


def _values(
    values: Mapping[str, WrittenValue], covariances: Mapping[str, Matrix], method: str
) -> Iterator[str]:
    """Deviations and intervals, against covariances in the order of the values."""
    for name, matrix in covariances.items():
        if problem := _misshapen(matrix, len(values)):
            yield f"the covariance {name} of {method} {problem}"
            return
    for i, (name, value) in enumerate(values.items()):
        deviations = written_deviations(value)
        low, high = value.interval_95
        if low > high:
            yield f"the interval of {name} by {method} ends before it begins"
        elif not low <= value.value - (value.filter_bias or 0.0) <= high:
            yield f"the interval of {name} by {method} does not hold its value less its bias"
        if min(*deviations.values(), value.sd_gain) < 0:
            yield f"a deviation of {name} by {method} is negative"
        for covariance, matrix in covariances.items():
            deviation = deviations.get(covariance)
            if deviation is None:
                yield f"{name} by {method} has no deviation for the covariance {covariance!r}"
            elif not _same(deviation**2 if deviation < 1e150 else math.inf, matrix[i][i]):
                yield f"the deviation {covariance} of {name} by {method} is not its covariance's"


def _misshapen(matrix: Sequence[Sequence[float]], size: int) -> str:
    if {len(matrix), *map(len, matrix)} != {size}:
        return f"is not of {size} parameters"
    if any(matrix[i][i] < 0 for i in range(size)):
        return "has a negative variance"
    if not all(_symmetric(matrix, i, j) for i in range(size) for j in range(i)):
        return "is not symmetric"
    return ""


def _symmetric(matrix: Sequence[Sequence[float]], i: int, j: int) -> bool:
    """Whether two members are one, to within what rounding is of their deviations."""
    size = math.sqrt(matrix[i][i]) * math.sqrt(matrix[j][j])
    return abs(matrix[i][j] - matrix[j][i]) <= _SAME * size + _NOTHING


def _same(first: float, second: float) -> bool:
    return math.isclose(first, second, rel_tol=_SAME, abs_tol=_NOTHING)
