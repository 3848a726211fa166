"""One self-contained HTML page a diagnosis: what it rests on as numbers, and the page that shows them."""
