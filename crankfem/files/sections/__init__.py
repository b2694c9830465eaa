"""The sections of engine files: every field with its unit, range and meaning, declared once."""
