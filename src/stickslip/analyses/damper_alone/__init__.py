"""A damper alone between two platforms that move as prescribed."""
