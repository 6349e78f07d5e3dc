"""Search in space and time: how a UAV waits on its way, lets others pass, and backs out."""
