"""From a scenario to a mission: which UAV flies to which target, along which path, and when."""
