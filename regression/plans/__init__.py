"""Plans of studies: what varies, which designs, what follows and what is excluded."""
