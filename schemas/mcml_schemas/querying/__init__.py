"""Questions about the library: XPath, search, facets, and what projects keep of them."""
