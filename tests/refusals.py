"""What is refused, by the code of the error: sentences are listed once, in the documentation."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import pytest

from axisid import AxisidError


@contextmanager
def refuses(code: str, says: str = "") -> Iterator[pytest.ExceptionInfo[AxisidError]]:
    """Fail unless the block raises the error of a code; it is given for what else it tells.

    Parameters
    ----------
    code : str
    says : str
        A pattern for the figures that its sentence has of the case, where the test is of these.
    """
    with pytest.raises(AxisidError, match=says or None) as refused:
        yield refused
    assert refused.value.code == code, f"{refused.value.code}: {refused.value}"


def refused(rows: Iterable[tuple[str, str, Callable[[], object]]]) -> Callable[..., None]:
    """A test of each row: what it makes is refused by its code, and says what it has to.

    Parameters
    ----------
    rows : iterable of (str, str, callable)
        Code and pattern as of `refuses`, and what is refused, without arguments.
    """

    @pytest.mark.parametrize(("code", "says", "make"), list(rows))
    def refuse(code: str, says: str, make: Callable[[], object]) -> None:
        with refuses(code, says):
            make()

    return refuse
