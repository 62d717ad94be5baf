"""High-precision references, written apart from the package from the published equations."""
