"""Reduced row echelon forms of numbers, of which rounding may have left a little.

The numbers have a fixed number of binary digits, and each the size of what was added up to it: what
rounding alone leaves where weights cancel counts as zero. A product of decimals computed in
floating point is not the product of these decimals.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from axisid.support.errors import ModelError

_DIGITS = 400  # binary, after the point
_ROUNDING = 10**12  # of which what was added up has to have one, to be more than rounding left
_EXACT = 10**45  # likewise of fractions that are meant,
_LARGEST_DENOMINATOR = 10**18  # and their denominators
_MOST_STEPS = 2_000_000  # numbers that are worked out

Row = list[Fraction]
#: Numbers by column, each with the size of what was added up to it; those left out are 0.
_Tracked = Mapping[int, tuple[int, int]]
_NOTHING = (0, 0)


def reduced_rows(weights: Sequence[Row]) -> tuple[list[Row], list[int]]:
    """Reduced row echelon form without its zero rows, and its pivot columns.

    A weight that is small beside others of its row is no rounding: ``(x - 9)**12`` has weights from
    1 to 3e11.

    Raises
    ------
    ModelError
        There are too many weights to be worked out.
    """
    width = len(weights[0]) if weights else 0
    scales = [max(_bits(row[j]) for row in weights) for j in range(width)]
    left, done = [_tracked(row, scales) for row in weights], list[_Tracked]()
    pivots: list[int] = []
    steps = 0
    for j in range(width):
        able = [row for row in left if _counts(*row.get(j, _NOTHING))]
        if not able:
            continue
        best = max(able, key=lambda row: _certainty(*row[j]))
        lead = _over(best, best[j][0])
        steps += len(lead) * (len(able) + sum(j in row for row in done))
        if steps > _MOST_STEPS:
            raise ModelError(
                "the parameters enter in too many products and sums to find which of them a "
                "record tells apart; declare what enters together as one parameter."
            )
        left = [_less(row, lead, j) for row in left if row is not best]
        done = [*(_less(row, lead, j) for row in done), lead]
        pivots.append(j)
    reduced = [
        [_weight(row.get(j, _NOTHING), scales[j] - scales[pivot]) for j in range(width)]
        for row, pivot in zip(done, pivots, strict=True)
    ]
    return reduced, pivots


def meant(value: Fraction) -> Fraction:
    """A number as it was meant: the fraction that it is to nearly all its digits, if it is one."""
    near = value.limit_denominator(_LARGEST_DENOMINATOR)
    return near if abs(near - value) * _EXACT <= abs(value) else value


def _tracked(row: Row, scales: Sequence[int]) -> _Tracked:
    """A row as it was given, over the scales of the columns and its own."""
    size = max((_bits(x) - scale for x, scale in zip(row, scales, strict=True) if x), default=0)
    whole = [
        round(x * Fraction(2) ** (_DIGITS - size - scale))
        for x, scale in zip(row, scales, strict=True)
    ]
    return {j: (x, abs(x)) for j, x in enumerate(whole) if x}


def _bits(value: Fraction) -> int:
    """Binary digits before the point, roughly."""
    return value.numerator.bit_length() - value.denominator.bit_length()


def _counts(value: int, size: int) -> bool:
    """Whether a number is more than what rounding may have left."""
    return abs(value) * _ROUNDING > size


def _certainty(value: int, size: int) -> tuple[int, int]:
    """How little has cancelled in a number; then how large it is."""
    return (abs(value) << 64) // size, abs(value)


def _over(row: _Tracked, divisor: int) -> _Tracked:
    return {
        j: ((x << _DIGITS) // divisor, (size << _DIGITS) // abs(divisor))
        for j, (x, size) in row.items()
    }


def _less(row: _Tracked, lead: _Tracked, j: int) -> _Tracked:
    """A row less what it has in column j of another, whose number there is 1."""
    share, more = row.get(j, _NOTHING)
    if not share:
        return row
    left = dict(row)
    for i, (y, least) in lead.items():
        x, size = row.get(i, _NOTHING)
        left[i] = x - (share * y >> _DIGITS), size + (more * least >> _DIGITS)
    return left


def _weight(number: tuple[int, int], bits: int) -> Fraction:
    if not _counts(*number):
        return Fraction(0)
    return meant(Fraction(number[0], 2**_DIGITS) * Fraction(2) ** bits)
