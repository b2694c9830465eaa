"""What diagrams of results are drawn by: functions of plain numbers that draw on axes given."""
