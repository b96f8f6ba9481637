"""Generated clips, small and plausible, so that a newcomer sees something at once. Seeded: equal seeds, equal clips."""
