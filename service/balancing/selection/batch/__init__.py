"""Many selections over the same planes and box: draws of a study, what-ifs, plans under uncertainty."""
