"""Angles of the body as OpenSim's tables. Written, not read."""
