"""The paper's experiment: references, flights, learning, choices, errors, figures, claims."""
