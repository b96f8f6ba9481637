"""Beats, bars, a motion graph, and choreography to a tempo or to music. Specification: docs/analyses/dance.md."""
