"""The service: an API over HTTP, and a page with sliders for a throw's dimensions."""
