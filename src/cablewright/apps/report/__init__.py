"""Self-contained reports: one HTML file that contains its pictures, and the pictures as files beside it."""
