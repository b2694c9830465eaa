"""Wrong and extreme input for tests and campaigns: hypothesis strategies, and what may come of them."""
