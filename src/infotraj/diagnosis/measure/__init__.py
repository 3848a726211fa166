"""What was measured against what a model predicts, and its coefficients in time and frequency."""
