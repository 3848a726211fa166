"""What a user gets: JSON, tables, figures, models and history."""
