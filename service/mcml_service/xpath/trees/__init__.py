"""Documents as trees of nodes, on which elementpath evaluates what columns have no answer to."""
