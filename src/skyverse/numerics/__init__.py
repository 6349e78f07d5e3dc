"""What all kernels build on: compilation, tolerances, norms, heaps, Bernstein polynomials, arrays."""
