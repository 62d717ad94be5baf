"""RODASP: its steps, and derivatives that follow the variational equation along them.

Its modules import diffrax, so they are imported only where something is integrated, and not here.
"""
