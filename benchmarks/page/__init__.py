"""One page and one JSON of all cases: error against run time, and what to choose when."""
