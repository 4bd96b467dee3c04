"""What is computed once for an object is kept as long as the object is alive."""

from axisid.support.caching import cached_while_alive


class Owner:
    """What a result is kept with; it has no hash."""

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Owner)


def test_a_result_is_kept_by_the_other_arguments_as_long_as_its_owner_lives() -> None:
    calls = []

    @cached_while_alive
    def computed(first: str, owner: Owner, number: int = 0) -> int:
        calls.append((first, number))
        return len(calls)

    one, equal = Owner(), Owner()
    assert [computed("a", one), computed("a", one), computed("b", one)] == [1, 1, 2]
    assert [computed("a", one, 1), computed("a", equal)] == [3, 4]
    del one
    assert computed("a", Owner()) == 5
