"""Shortest paths of any angle.

Among boxes: a first path through free cells, tightened window by window over the edges of boxes, and a lower bound.
Among shapes of any kind: several first paths, shortened along lines of sight.
"""
