"""The study of hidden effects: plants that hide some, the diagnosis of their flights, scores."""
