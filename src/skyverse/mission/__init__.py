"""From a scenario to a mission: who flies where, along which path, at what time."""
