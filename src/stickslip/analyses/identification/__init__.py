"""Contact parameters and laws from measured loops."""
