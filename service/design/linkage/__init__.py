"""The linkage study: masses of a planar linkage of dyads, and what they do to its frame."""
