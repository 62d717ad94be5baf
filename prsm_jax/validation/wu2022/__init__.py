"""Wu et al. 2022: stiffness, pressures, natural frequencies and mode shapes."""
