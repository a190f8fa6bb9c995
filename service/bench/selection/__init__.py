"""`drumtrue bench selection`: time to proof, quality and success rate next to named peers."""
