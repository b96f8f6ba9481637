"""Parameterised reach motion: labelled clips to a motion for any attributes (docs/analyses/reach.md)."""
