"""Many starts at once against searches one by one."""
