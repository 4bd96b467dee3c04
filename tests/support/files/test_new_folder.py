"""A folder that is made to write into."""

from pathlib import Path

import pytest

from axisid.support.files.regular_file import kept_if_filled


@pytest.mark.parametrize(("was_there", "filled"), [(False, False), (False, True), (True, False)])
def test_a_new_folder_goes_again_where_nothing_came_into_it(
    tmp_path: Path, was_there: bool, filled: bool
) -> None:
    place = tmp_path / "out"
    if was_there:
        place.mkdir()
    with pytest.raises(KeyError), kept_if_filled(place):
        if filled:
            (place / "a").touch()
        raise KeyError
    assert place.exists() == (was_there or filled)


def test_a_folder_that_is_done_with_stays(tmp_path: Path) -> None:
    with kept_if_filled(tmp_path / "of" / "results"):
        pass
    assert (tmp_path / "of" / "results").is_dir()
