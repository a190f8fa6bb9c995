"""The gear pair study: module, face width and teeth of a helical pair."""
