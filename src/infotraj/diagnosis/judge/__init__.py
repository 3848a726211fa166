"""The verdicts: evidence, groups, numbers, what is left, and the model that is given."""
