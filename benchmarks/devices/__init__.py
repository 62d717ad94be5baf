"""Designs a second on every device that JAX sees, and how much of the device that is."""
