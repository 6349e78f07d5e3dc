"""The laboratory: planners compared over scenarios, budgets and seeds, one row a run."""
