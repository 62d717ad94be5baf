"""Lisowski 2014: contact pressures."""
