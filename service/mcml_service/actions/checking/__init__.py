"""Checks before an action: names, preconditions; and errors for refusals."""
