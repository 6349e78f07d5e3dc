"""Shortest paths: exact on a lattice, and of any angle."""
