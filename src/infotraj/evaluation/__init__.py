"""What is measured on a flight or over many: errors, intervals, claims."""
