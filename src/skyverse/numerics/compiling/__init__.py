"""How kernels become machine code, and where the machine code is kept."""
