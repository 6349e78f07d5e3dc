"""The command line: each verb is a few lines over the public API; bad input ends in one sentence and exit code 2."""

import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from skyverse._version import __version__
from skyverse.cli.cache import cache
from skyverse.cli.compare import compare
from skyverse.cli.exit_codes import BAD_INPUT, FOUND_WRONG, INTERRUPTED
from skyverse.cli.export import export
from skyverse.cli.fly import fly
from skyverse.cli.missions import check, show
from skyverse.cli.option_names import for_command_line
from skyverse.cli.plan import plan
from skyverse.cli.reproduce import reproduce
from skyverse.cli.scenario import app as scenario_app
from skyverse.cli.scenarios import scenarios
from skyverse.errors import InputError

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
for verb in (scenarios, plan, check, show, export, fly, compare, reproduce, scenario_app, cache):
    app.command(verb)


def main(words: Sequence[str] | None = None) -> None:
    """Run a command line, by default that of this process, and end the process with its exit code."""
    given = sys.argv[1:] if words is None else words
    if not given:
        print(FIRST_STEPS, end="")
        sys.exit(0)
    try:
        code = app(given, exit_on_error=False, print_error=False, result_action="return_value")
    except UnusedCliTokensError as error:
        found = " ".join(map(repr, error.unused_tokens or ()))
        _fail(f"expected each of several values after its own option, as in --uav A --uav B, found {found} without one")
    except CycloptsError as error:
        _fail(" ".join(str(error).split()))
    except InputError as error:
        _fail(for_command_line(error))
    except MemoryError:
        _fail("this machine has too little memory; take longer lattice steps, smaller bounds or fewer paths")
    except KeyboardInterrupt:
        print("skyverse: interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(FOUND_WRONG)
    sys.exit(code)


def _fail(sentence: str) -> None:
    print(f"skyverse: {sentence}", file=sys.stderr)
    sys.exit(BAD_INPUT)
