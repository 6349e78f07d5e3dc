"""What is given and what is answered: frozen data with validated fields, and no kernels."""
