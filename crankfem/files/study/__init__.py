"""The section [study], and the user's designs from CSV files."""
