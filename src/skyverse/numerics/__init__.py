"""The numerical ground floor: how kernels are compiled, heaps, Bernstein polynomials, arrays."""
