"""The shaft set study: correction masses in several planes for three aims at once."""
