"""What may be missing, its columns, and sums over blocks of flights."""
