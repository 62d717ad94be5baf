"""Fronts by gradients against NSGA-II of pymoo: dominated volume at equal reference point."""
