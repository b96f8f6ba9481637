"""Joint centres, joint angles, moments and powers from the markers of a gait laboratory."""
