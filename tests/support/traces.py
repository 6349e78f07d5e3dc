"""What is read out of the traces of a page, and out of surfaces."""

import base64

import numpy as np


def numbers(packed):
    """Return the numbers of an array as the page carries it."""
    values = np.frombuffer(base64.b64decode(packed["bdata"]), {"f4": np.float32, "i4": np.int32}[packed["dtype"]])
    return values.reshape([int(side) for side in packed["shape"].split(", ")]) if "shape" in packed else values


def columns(trace, names):
    """Return the numbers of a trace as rows."""
    return np.column_stack([numbers(trace[name]) for name in names])


def of_role(traces, role):
    """Return the traces that show one thing."""
    return [trace for trace in traces if trace["meta"]["role"] == role]


def enclosed(points, triangles):
    """Return the volume inside a surface that is counter-clockwise seen from outside."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.sum(a * np.cross(b, c)) / 6


def area(points, triangles):
    """Return the area of a surface."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
