"""Rotating machines: structures over the rotor speed, Campbell and interference diagrams."""
