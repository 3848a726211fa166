"""The learned residual g of f = h + g (eq. 3): a Gaussian process, its draws, its variance and its training points."""
