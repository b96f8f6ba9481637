"""From text to tree: tokens, grammar, the FUNCTIONS table, the meaning of expressions, and rules that rewrite them."""
