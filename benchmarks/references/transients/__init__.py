"""Transients apart from the package: settling, prescribed torque, and programs for rivals."""
