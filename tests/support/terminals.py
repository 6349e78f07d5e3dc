"""Streams that a person watches."""

import io
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from unittest import mock


class Terminal(io.TextIOWrapper):
    """A terminal that shows no more than the characters of an encoding."""

    def __init__(self, encoding):
        super().__init__(io.BytesIO(), encoding=encoding, newline="\n")

    def isatty(self):
        return True

    @property
    def sent(self):
        """All that it was sent."""
        self.flush()
        return self.buffer.getvalue().decode(self.encoding)


@contextmanager
def on_a_terminal(width, encoding="utf-8"):
    """Let both standard streams be a terminal of so many columns, without colours, and yield it."""
    with mock.patch.dict("os.environ", COLUMNS=str(width), NO_COLOR="1", TERM="xterm"):
        terminal = Terminal(encoding)
        with redirect_stdout(terminal), redirect_stderr(terminal):
            yield terminal
