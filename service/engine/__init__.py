"""The kernel on documents, without storage: runs -> correction -> plan."""
