"""``python -m skyverse``."""

from skyverse.cli import main

if __name__ == "__main__":
    main()
