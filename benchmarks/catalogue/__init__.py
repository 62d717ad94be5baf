"""Beat the catalogue: the best design within the envelope of each of 90 sizes."""
