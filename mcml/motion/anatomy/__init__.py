"""A body as anatomy sees it: its axes, the angles of its joints, the names of its movements."""
