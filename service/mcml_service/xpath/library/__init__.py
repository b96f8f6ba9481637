"""What is kept of a library between questions: documents in groups, zone maps, tracks, shared skeletons."""
