"""Which named physical effect a model lacks, how sure that is, and what adding it brings."""
