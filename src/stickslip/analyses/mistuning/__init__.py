"""Mistuned disks and populations of them."""
