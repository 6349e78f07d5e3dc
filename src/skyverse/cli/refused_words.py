"""What is said of words on a command line that no verb can be run with, in the words of all other messages."""

import inspect
import re

from cyclopts import CoercionError, CycloptsError, MissingArgumentError, UnknownCommandError, UnusedCliTokensError


def refusal(error: CycloptsError) -> str:
    """Return in one sentence what is wrong with a command line, as cyclopts found it."""
    if isinstance(error, UnusedCliTokensError):
        return _too_many_words(error)
    if isinstance(error, MissingArgumentError) and error.argument is not None and not error.argument.tokens:
        return _missing_word(error)
    if isinstance(error, UnknownCommandError) and error.app is not None and error.unused_tokens:
        word, verbs = error.unused_tokens[0], [name for name in error.app if not name.startswith("-")]
        under = [f"{verb} {word}" for verb in verbs if word in list(error.app[verb]) and not word.startswith("-")]
        if under:
            return f"expected a verb, found {word!r}; did you mean {under[0]!r}?"
    said = " ".join(str(error).split())
    token = error.token if isinstance(error, CoercionError) else None
    if token is not None and token.keyword == "--planner" and ":" in token.value:
        return f"{said} A planner of one's own, module:Class, stands in a study file, as skyverse compare takes it."
    return said


def _too_many_words(error: UnusedCliTokensError) -> str:
    """Say how many words a verb takes, and how several values of an option are given."""
    found = " ".join(map(repr, error.unused_tokens or ()))
    given = inspect.signature(error.target).parameters.values() if error.target is not None else ()
    taken = [one.name.upper() for one in given if one.kind is one.POSITIONAL_ONLY]
    verb = " ".join(error.command_chain or ())
    return (
        f"{verb}: expected {' and '.join(taken) or 'options'} alone, found {found} too; "
        "several values of an option stand each after its name, as in --uav A --uav B"
    )


def _missing_word(error: MissingArgumentError) -> str:
    """Say which word a verb, or a value which option, lacks, with the first example of the verb's help."""
    verb = " ".join(error.command_chain or ())
    example = re.search(r"`(skyverse [^`]+)`", inspect.getdoc(error.target) or "")
    more = f"; an example: {' '.join(example[1].split())}" if example else ""
    if error.keyword is not None:
        return f"{error.keyword}: expected a value after it, found none"
    return f"{verb}: expected {error.argument.name if error.argument is not None else 'more'}{more}"
