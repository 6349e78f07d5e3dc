"""Steers a mission by what stands on one stream, and answers on another."""

from typing import BinaryIO

from skyverse.interrupt import on_interrupt
from skyverse.live.messages import Answer, Hello, Refusal
from skyverse.live.observation_lines import LineSplitter
from skyverse.live.session import LiveSession

CHUNK = 2**16
"""Bytes that are read at once at most."""


def message_line(message: Hello | Answer | Refusal) -> bytes:
    """Return a message as a line of JSON; what is not there is left out only where nothing could be."""
    return message.model_dump_json().encode() + b"\n"


class _Interrupt:
    """Ctrl-C, which ends the program while it waits for input, or else after the line that is being answered.

    If it is pressed again, the program ends at once.
    """

    def __init__(self) -> None:
        self.waiting = self.asked = False

    def __call__(self, *_: object) -> None:
        if self.waiting or self.asked:
            raise KeyboardInterrupt
        self.asked = True

    def read(self, source: BinaryIO) -> bytes:
        """Wait for input and return it, empty at its end."""
        self.waiting = True
        if self.asked:
            raise KeyboardInterrupt
        chunk = source.read1(CHUNK)  # type: ignore[attr-defined]
        self.waiting = False
        return chunk


def serve_streams(session: LiveSession, source: BinaryIO, sink: BinaryIO) -> None:
    """Answer all lines of a stream, one after another, until it ends; each answer is written as soon as it is known.

    Parameters
    ----------
    session
        The mission.
    source
        Where lines come from.
    sink
        Where a hello and the answers go.

    Raises
    ------
    KeyboardInterrupt
        If Ctrl-C was pressed; then the last line is whole.
    OSError
        If nothing can be written.
    """
    splitter, interrupt, number = LineSplitter(), _Interrupt(), 0
    with on_interrupt(interrupt):
        _send(sink, session.hello())
        ended = False
        while not ended:
            chunk = interrupt.read(source)
            ended = not chunk
            for line in splitter.end() if ended else splitter.lines(chunk):
                number += 1
                answer = session.answer(line, number)
                if answer is not None:
                    _send(sink, answer)
                if interrupt.asked:
                    raise KeyboardInterrupt


def _send(sink: BinaryIO, message: Hello | Answer | Refusal) -> None:
    sink.write(message_line(message))
    sink.flush()
