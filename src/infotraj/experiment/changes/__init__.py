"""The study of changes: flights before and after an effect changed."""
