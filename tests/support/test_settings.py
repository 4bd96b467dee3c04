"""Settings in sentences as arguments, options and keys of a run.toml."""

from collections.abc import Mapping

import pytest

from axisid.support.settings import (
    SettingValue,
    other_command,
    setting,
    settings_in_python,
    settings_typed,
)

NO_OPTION: Mapping[str, str] = {}


@pytest.mark.parametrize(
    ("name", "value", "argument", "option", "key"),
    [
        ("gaps", "split", 'gaps="split"', "--gaps split", 'gaps = "split" in run.toml'),
        ("skip_bad", True, "skip_bad=True", "--skip-bad", "skip_bad = true in run.toml"),
        (
            "local",
            ("M", "Fc"),
            'local=["M", "Fc"]',
            "--local M,Fc",
            'local = ["M", "Fc"] in run.toml',
        ),
        (
            "columns",
            {"position": "NAME"},
            'columns={"position": "NAME"}',
            "--columns position=NAME",
            'columns = { position = "NAME" } in run.toml',
        ),
        (
            "known",
            {"m_add": ("V1", "V2")},
            'known={"m_add": [V1, V2]}',
            "--known m_add=V1,V2",
            "known = { m_add = [V1, V2] } in run.toml",
        ),
        ("resample", "200", "resample=200", "--resample 200", "resample = 200 in run.toml"),
    ],
)
def test_a_setting_is_spelled_as_its_user_types_it(
    name: str, value: SettingValue, argument: str, option: str, key: str
) -> None:
    assert setting(name, value) == argument
    with settings_typed({name: f"--{name.replace('_', '-')}"}, {name}):
        assert setting(name, value) == option
    with settings_typed(NO_OPTION, {name}):
        assert setting(name, value) == key
    with settings_typed(NO_OPTION, ()):
        assert setting(name, value) == argument


def test_an_option_may_have_another_name_than_the_argument() -> None:
    with settings_typed({"methods": "--method"}, ()):
        assert setting("methods", "didim") == "--method didim"


def test_the_spelling_of_a_command_ends_with_the_command() -> None:
    with pytest.raises(ZeroDivisionError), settings_typed({"gaps": "--gaps"}, ()):
        raise ZeroDivisionError
    assert setting("gaps", "split") == 'gaps="split"'


def test_fixed_and_left_out_parameters_are_functions_of_an_axis_in_python() -> None:
    assert setting("fix", {"M": "VALUE"}) == "fix(axis, M=VALUE)"
    assert setting("leave_out", "Fc") == 'leave_out(axis, "Fc")'
    with settings_typed({"fix": "--fix", "leave_out": "--leave-out"}, ()):
        assert setting("fix", {"M": "VALUE"}) == "--fix M=VALUE"
        assert setting("leave_out", "Fc") == "--leave-out Fc"


def test_another_command_is_a_function_in_python() -> None:
    assert other_command("fit", "output", "force") == 'axisid.fit(..., output="force")'
    with settings_typed(NO_OPTION, ()):
        assert other_command("fit", "output", "force") == "axisid fit --output force"


def test_names_keep_their_quotes_and_characters() -> None:
    assert setting("columns", {"position": "U (+-10V):V"}) == 'columns={"position": "U (+-10V):V"}'
    assert setting("local", ("nan", 'a"b')) == r'local=["nan", "a\"b"]'
    assert setting("known", {"M": ("100+-1",)}) == 'known={"M": [(100, 1)]}'


def test_texts_of_files_are_spelled_as_in_python() -> None:
    with settings_typed({"gaps": "--gaps"}, ()), settings_in_python():
        assert setting("gaps", "split") == 'gaps="split"'
