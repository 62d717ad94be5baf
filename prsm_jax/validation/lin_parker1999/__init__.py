"""Lin and Parker 1999: natural frequencies of planetary gears."""
