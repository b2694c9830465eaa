"""What a person wrote, read and checked: engines, mechanisms, chains, hinges, studies, tables."""
