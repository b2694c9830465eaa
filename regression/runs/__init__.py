"""Running studies: workers, cluster, store, tables in and out."""
