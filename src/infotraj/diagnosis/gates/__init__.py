"""Whether these data can say anything, axis by axis."""
