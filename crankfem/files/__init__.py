"""Files of users, read and checked: engines, mechanisms, chains, studies, tables."""
