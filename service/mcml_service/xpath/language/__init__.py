"""From text to tree: tokens, grammar, the FUNCTIONS table, what an expression means, and rules that rewrite it."""
