"""Landmarks of a body: which marker stands where, by the set that a laboratory uses, by words, and checked by place."""
