"""Expected values of the matrix, apart from the package."""
