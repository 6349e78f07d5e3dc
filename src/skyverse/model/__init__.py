"""What is given and what is answered: plain frozen data, without kernels."""
