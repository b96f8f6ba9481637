"""Several dancers on one stage. Specification: docs/analyses/dance.md, "Several dancers"."""
