"""Puts `test_repair`, whose helpers other tests share, on the path."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
