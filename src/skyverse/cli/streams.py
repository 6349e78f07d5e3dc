"""Standard output and standard error as the program writes to them: no text fails, and none commands the terminal."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from io import TextIOWrapper
from pathlib import Path
from typing import Any, TextIO, cast

_COMMANDS = re.compile("[\x00-\x08\x0b-\x1e\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Control characters but tab, newline and the unit separator, which parts what a shell completes and commands nothing;
and those that turn the direction of the text after them."""


def plain(text: str) -> str:
    r"""Return a text with what a terminal would obey, as in a file's name, written as in Python: ``\x1b``."""
    return _COMMANDS.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


class _PlainStream:
    """A stream whose text is made plain; rich, which knows the attribute from its own streams, styles past it."""

    def __init__(self, stream: TextIO) -> None:
        self.rich_proxied_file = stream

    def write(self, text: str) -> int:
        return self.rich_proxied_file.write(plain(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rich_proxied_file, name)


def below(stream: TextIO) -> TextIO:
    """Return the stream that others, which change its text, write to at last."""
    while hasattr(stream, "rich_proxied_file"):
        stream = stream.rich_proxied_file
    return stream


@contextmanager
def plain_streams() -> Iterator[None]:
    """Write plain text to the standard streams, with escapes for what they cannot encode; to a closed one, nothing."""
    with ExitStack() as left:
        for stream, redirect in ((sys.stdout, redirect_stdout), (sys.stderr, redirect_stderr)):
            written = stream or left.enter_context(Path(os.devnull).open("w", encoding="utf-8"))
            if isinstance(written, TextIOWrapper):
                written.reconfigure(errors="backslashreplace")
            left.enter_context(redirect(cast(TextIO, _PlainStream(written))))
        yield
