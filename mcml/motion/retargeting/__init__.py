"""Retarget a motion to another skeleton: matching joints, rotating limbs, and the report."""
