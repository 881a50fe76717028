"""Self-contained reports: one HTML file with its pictures inside, and the pictures as files beside it."""
