"""What ships beside the code: flights to try the commands on, and vehicle files."""
