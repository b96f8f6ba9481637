"""Analyses: one folder a subject, pure functions on arrays; `catalogue` lists what users may run."""
