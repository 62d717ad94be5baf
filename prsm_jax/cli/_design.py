"""Verbs that improve a design (filled in with the rooms they call)."""
