"""Export of a job's motion to firmware: points, winch angles, and the other commands of the job's file."""
