"""The thesis's experiments, run again: its tables, its figures, and what becomes of its claims."""
