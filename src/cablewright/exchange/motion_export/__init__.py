"""A job's motion as files of a firmware: points, winches, and what the job's own file has beside motion."""
