"""The exact search: the best selection and its proof, level by level."""
