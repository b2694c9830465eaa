"""The service: an API over HTTP, and a page on which a throw's dimensions are turned like knobs."""
