"""Design studies: answered at once, kept with their versions, computed in runs that last."""
