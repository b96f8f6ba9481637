"""The store as a whole: checked, sealed, moved project by project."""
