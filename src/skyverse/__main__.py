"""The program ``skyverse``, also started as ``python -m skyverse``."""

import signal
import sys


def main() -> None:
    """Run the command line of this process; Ctrl-C ends it with one sentence, also while its modules load."""
    try:
        from skyverse.cli import main as run

        run()
    except KeyboardInterrupt:
        print("skyverse: interrupted", file=sys.stderr)
        sys.exit(130)  # skyverse.cli.exit_codes may not have been loaded
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C while Python clears up ends the process in silence


if __name__ == "__main__":
    main()
