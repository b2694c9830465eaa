"""The main job: its folder, progress, interruption and resumption."""
