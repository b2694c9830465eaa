"""The service: an API over HTTP, and a page where sliders change a throw's dimensions."""
