"""Plans of studies: factors, designs, relations and exclusions."""
