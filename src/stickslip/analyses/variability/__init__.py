"""Responses that are not unique: samples, histories, bounds and freedom of the start states."""
