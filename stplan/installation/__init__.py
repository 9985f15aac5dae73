"""What is installed here, whether it works, and its kernels compiled ahead of the first plan."""
