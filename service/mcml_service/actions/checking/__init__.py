"""What is checked before anything is done: names, preconditions; and how a refusal is told."""
