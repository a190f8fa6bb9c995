"""`drumtrue bench`: measurements against named peers and limits, always in one run on one machine."""
