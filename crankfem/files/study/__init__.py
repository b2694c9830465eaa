"""The section [study], and designs of one's own from CSV files."""
