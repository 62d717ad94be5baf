"""A million designs: designs per second, time outside the kernel, memory, threads, and SciPy."""
