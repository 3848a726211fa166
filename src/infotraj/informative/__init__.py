"""Which reference teaches the model most: simulation, region, cost and selection (Sec. III)."""
