"""Shortest paths of any angle among boxes: a first way, the search over edges, and the bound."""
