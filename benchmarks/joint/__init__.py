"""Derivatives of several quantities together: what they cost beside the values, and how wrong."""
