"""Gait parameters of many trials, by trial and by subject. Specification: docs/analyses/gait.md."""
