"""What other people's scripts rely on stays: the public names, and the verbs and options of the command line.

`public_names.txt` holds the names, and `public_options.txt` the options, one a line: the verb, what the option is
called, what it takes, and its default. Both are those of version 0.1.0.
"""

import types
import typing
from pathlib import Path

import skyverse as sky
from skyverse.cli import app

HERE = Path(__file__).parent
NOT_AN_OPTION = "--empty-"  # cyclopts adds these to options that may be given several times


def lines(name):
    return (HERE / name).read_text(encoding="utf-8").splitlines()


def taken(hint):
    """Return what an option takes, in words; it is the same whether the option may be left out or not."""
    given = typing.get_args(hint) if typing.get_origin(hint) in (typing.Union, types.UnionType) else (hint,)
    (hint,) = (one for one in given if one is not types.NoneType)
    if typing.get_origin(hint) is typing.Literal:
        return "|".join(typing.get_args(hint))
    if typing.get_origin(hint) in (list, tuple):
        return f"several {taken(typing.get_args(hint)[0])}"
    return str(hint.__name__).lower().replace("posixpath", "path")


def options(app, verb=""):
    """Yield each option of each verb as a line."""
    for name in app:
        if not name.startswith("-"):
            yield from options(app[name], f"{verb} {name}".strip())
    if app.default_command is not None:
        for option in app.assemble_argument_collection(parse_docstring=False):
            if option.name == "*":  # several options together, each of which comes as well
                continue
            names = " ".join(name for name in option.names if not name.startswith(NOT_AN_OPTION))
            default = option.field_info.default
            said = f" = {default}" if isinstance(default, bool | int | float | str) else ""
            yield f"{verb} {names}: {taken(option.hint)}{said}"


def test_the_public_names_are_those_of_0_1_0():
    assert sorted(sky.__all__) == lines("public_names.txt")


def test_every_verb_and_option_of_0_1_0_is_there_and_no_verb_has_another():
    known = lines("public_options.txt")
    verbs = {line.split(" ")[0] for line in known}
    assert sorted(line for line in options(app) if line.split(" ")[0] in verbs) == known
