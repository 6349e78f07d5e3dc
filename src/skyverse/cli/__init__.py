"""The command line: each verb is a few lines over the public API; bad input ends in one sentence and exit code 2."""

import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Literal
from unicodedata import category

from cyclopts import App, CycloptsError, Parameter

from skyverse._version import __version__
from skyverse.cli.cache import cache
from skyverse.cli.cameras import cameras
from skyverse.cli.check import check
from skyverse.cli.compare import compare
from skyverse.cli.exit_codes import BAD_INPUT, INTERRUPTED, OUTPUT_CLOSED
from skyverse.cli.export import export
from skyverse.cli.fly import fly
from skyverse.cli.live import live
from skyverse.cli.missions import show
from skyverse.cli.option_names import for_command_line, refusal, running
from skyverse.cli.outputs import settle_folders
from skyverse.cli.plan import plan
from skyverse.cli.repair import repair
from skyverse.cli.reproduce import reproduce
from skyverse.cli.scenario import app as scenario_app
from skyverse.cli.scenarios import scenarios
from skyverse.cli.streams import plain_streams
from skyverse.cli.survey import survey
from skyverse.cli.watch import compile_with_bar
from skyverse.errors import InputError, shown
from skyverse.extras import told_imports
from skyverse.numerics.compiling import before_compiling

WHAT_IT_DOES = "Plan, prove and export 3-D missions for fleets of UAVs."
FIRST_STEPS = f"""{WHAT_IT_DOES}

Three things to try first:

  skyverse plan table-4.8
      plans a fleet of five UAVs, proves that its flight is safe, and draws it in out/table-4.8.html
  skyverse show out/table-4.8.json --open
      opens the flight in the browser; `skyverse export --help` tells how to take it to an autopilot
  skyverse scenarios map1 -o mine.yaml
      writes a scenario for you to change; `skyverse plan mine.yaml` plans it

`skyverse --help` lists all verbs.
"""

app = App(
    name="skyverse",
    version=__version__,
    help=f"{WHAT_IT_DOES}\n\nExample: `skyverse plan table-4.8`",
    help_format="markdown",
    default_parameter=Parameter(negative_iterable=()),
    suppress_keyboard_interrupt=False,
)
_LONG_WORD = r"\S{300,}"
for verb in (scenarios, plan, survey, check, repair, show, export, fly, live, compare, reproduce, scenario_app, cache):
    app.command(verb)
app.command(cameras)


@app.command(name="--install-completion")
def install_completion(*, shell: Literal["bash", "zsh", "fish", "powershell"] | None = None) -> None:
    """Let the shell complete verbs, options, planners, scenarios and files when TAB is pressed.

    Parameters
    ----------
    shell
        The shell; found out when left out.
    """
    from cyclopts.completion import ShellDetectionError

    try:
        written = app.install_completion(shell=shell)
    except ShellDetectionError:
        raise InputError("--shell: expected bash, zsh, fish or powershell, as this shell is not known") from None
    print(f"{written}\nA new shell completes what you type.")


def main(words: Sequence[str] | None = None) -> None:
    """Run a command line, by default that of this process, and end the process with its exit code."""
    with plain_streams():
        sys.exit(_exit_code(sys.argv[1:] if words is None else words))


def _exit_code(given: Sequence[str]) -> int | None:
    """Run a command line to its end, whatever becomes of its output, and return its exit code."""
    try:
        try:
            with running(app, given):
                code = _run(given)
        finally:
            settle_folders()
        sys.stdout.flush()  # what cannot be written is told here, and not by Python when it ends
    except BrokenPipeError:
        code = _output_closed()
    except SystemExit as ended:
        if not isinstance(ended.__context__, BrokenPipeError):
            raise
        code = _output_closed()  # rich, which prints help and tables, ends the program itself
    except OSError as error:
        _drop_output()
        where = error.filename or "the output cannot be written"
        code = _failed(f"{where}: {error.strerror or error}")
    return code


def _run(given: Sequence[str]) -> int | None:
    """Run a command line and return its exit code; ``None`` counts as 0."""
    if not given:
        print(FIRST_STEPS, end="")
        return 0
    odd = next((word for word in given if any(category(sign) == "Cc" for sign in word)), None)
    if odd is not None:  # a newline among them would tell lines of its own wherever the word is told
        return _failed(f"expected words and names of files without control characters, found {shown(odd, 200)}")
    before_compiling(partial(compile_with_bar, given[:1]))  # what the list of kernels has under the name of the verb
    try:
        with told_imports():
            return app(given, exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        return _failed(refusal(error))
    except InputError as error:
        return _failed(for_command_line(error))
    except MemoryError:
        return _failed("this machine has too little memory; take longer lattice steps, smaller bounds or fewer paths")
    except KeyboardInterrupt as stopped:  # it may tell what is kept
        print("; ".join(["skyverse: interrupted", *map(str, stopped.args)]), file=sys.stderr)
        return INTERRUPTED


def _failed(sentence: str) -> int:
    """Print why a command line cannot be run, with overlong words cut short, and return the exit code."""
    with suppress(OSError):
        print(f"skyverse: {re.sub(_LONG_WORD, lambda word: f'{word[0][:60]}...', sentence)}", file=sys.stderr)
    return BAD_INPUT


def _output_closed() -> int:
    """Return the exit code for output whose reader has gone, about which there is nothing to say to anyone."""
    _drop_output()
    return OUTPUT_CLOSED


def _drop_output() -> None:
    """Let standard output lead nowhere, so that Python does not fail on it again when it ends."""
    with suppress(OSError, ValueError), Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())
