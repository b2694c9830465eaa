"""Files of users, read and checked: engines, mechanisms, chains, hinges, studies, tables."""
