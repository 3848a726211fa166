"""The corpus of logs that `check` is measured on."""
